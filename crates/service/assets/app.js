// The page's own module: upload, questions, what-if.
const at = (id) => document.getElementById(id);
const tell = (text) => { at('told').textContent = text; setTimeout(() => { at('told').textContent = ''; }, 4000); };

// An error that a field is to blame for.
const wrong = (key, text) => Object.assign(new Error(text), { key });

async function reach(path, options) {
  try { return await fetch(path, options); } catch { throw new Error('The server does not answer. Check the network, then try again.'); }
}

async function asked(path, body, kind = 'application/json') {
  const answer = await reach(path, body === undefined ? {} : { method: 'POST', headers: { 'content-type': kind }, body: typeof body === 'string' ? body : JSON.stringify(body) });
  const json = await answer.json();
  if (!answer.ok) throw new Error(json.detail || answer.statusText);
  return { status: answer.status, json };
}

// ---------------------------------------------------------------- fields

const fieldOf = (key) => document.querySelector(`main [name="${CSS.escape(key)}"]`);
const labelOf = (key) => (key === 'channel' ? 'Channel' : fieldOf(key)?.labels?.[0]?.firstChild.textContent.trim());

// Words a message of the interface for whoever sees the page: its fields go by their labels here.
function worded(text) {
  return text.replace(/^(request|set|design|name): /, '')
    .replace(/; choose one with the field `request.channel` = NAME/, '')
    .replace(/the field `(?:request\.)?([\w.]+)`( =)?/g, (whole, key, is) => (labelOf(key) ? `“${labelOf(key)}”${is ? ' as' : ''}` : whole))
    .replace(/\b(?:lever|stop|criterion|input)\.\w+/g, (key) => (labelOf(key) ? `“${labelOf(key)}”` : key));
}

// Finds the field that a message of the interface is about.
function keyOf(text) {
  const found = /request\.(\w+)/.exec(text) || /\b((?:lever|stop|criterion|input)\.\w+)/.exec(text) || /^(name): /.exec(text);
  return found ? found[1] : '';
}

function clearMarks() {
  for (const note of document.querySelectorAll('.error[data-note]')) note.remove();
  for (const field of document.querySelectorAll('[data-marked]')) { field.removeAttribute('aria-invalid'); field.removeAttribute('aria-describedby'); delete field.dataset.marked; }
  for (const place of document.querySelectorAll('p.error')) place.textContent = '';
}

function mark(field, text) {
  const note = document.createElement('span');
  note.className = 'error'; note.dataset.note = ''; note.setAttribute('role', 'alert');
  note.id = `error-${field.name || field.id}`; note.textContent = text;
  field.after(note);
  field.dataset.marked = ''; field.setAttribute('aria-invalid', 'true'); field.setAttribute('aria-describedby', note.id);
  const folded = field.closest('details');
  if (folded) folded.open = true;
}

// Marks the field that is to blame; says beside the button what no field is to blame for.
function blame(error, told) {
  const key = error.key || keyOf(error.message);
  const field = key && fieldOf(key);
  if (key === 'channel' && at('channel-error')) { at('channel-error').textContent = worded(error.message); at('channel-error').scrollIntoView({ block: 'center' }); return; }
  if (!field) { told.textContent = worded(error.message); return; }
  mark(field, worded(error.message));
  field.focus();
}

// Reads a number with a decimal point or comma; returns it with a point.
function numberIn(field) {
  const text = field.value.trim().replace('\u2212', '-').replace(',', '.');
  if (!/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text)) throw wrong(field.name, `Type a number, as 4.5 or 4,5. Found “${field.value.trim()}”.`);
  return text;
}

const numbersOf = (form) => [...form.querySelectorAll('[data-number]')];
const changesIn = (form) => numbersOf(form).filter((field) => field.value.trim()).map((field) => `${field.name}=${numberIn(field)}`);

// Empty fields show the numbers of the design that is chosen.
function showNumbers(form) {
  const select = form.querySelector('[data-designs]');
  const show = () => {
    const numbers = JSON.parse(select.selectedOptions[0].dataset.numbers);
    for (const field of numbersOf(form)) { const [table, key] = field.name.split('.'); field.placeholder = numbers[table][key]; }
  };
  select.addEventListener('change', show); show();
}

// ---------------------------------------------------------------- upload

function upload(files) {
  const told = at('upload-told'); const bar = at('upload');
  const list = [...files];
  if (list.length === 0) return;
  const form = new FormData();
  // What ends with .toml beside a file of its name is that file's card.
  const names = list.map((file) => file.name);
  const isCard = (file) => file.name.endsWith('.toml') && names.includes(file.name.slice(0, -5));
  const main = list.find((file) => !isCard(file) && file.name.toLowerCase().endsWith('.mme')) || list.find((file) => !isCard(file));
  for (const file of list) {
    const role = isCard(file) ? 'card' : file === main ? 'file' : 'part';
    form.append(role, file, file.webkitRelativePath || file.name);
  }
  const request = new XMLHttpRequest();
  request.open('POST', '/v1/recordings');
  request.responseType = 'json';
  bar.hidden = false;
  request.upload.onprogress = (event) => { if (event.lengthComputable) bar.value = event.loaded / event.total; told.textContent = 'Uploading …'; };
  request.upload.onload = () => { bar.removeAttribute('value'); told.textContent = 'Reading …'; };
  request.onerror = () => { bar.hidden = true; told.textContent = 'The upload was cut. Check the network, then try again.'; };
  request.onload = () => {
    bar.hidden = true;
    const { response, status } = request;
    if (status === 200 || status === 201) {
      told.textContent = status === 200 ? 'Known already.' : 'Kept.';
      location.href = `/recordings/${response.id}${status === 200 ? '#known' : ''}`;
    } else told.textContent = worded((response && response.detail) || `Refused (${status}).`);
  };
  request.send(form);
}

function dropZone(zone) {
  for (const kind of ['dragover', 'dragenter']) zone.addEventListener(kind, (event) => { event.preventDefault(); zone.classList.add('over'); });
  for (const kind of ['dragleave', 'drop']) zone.addEventListener(kind, () => zone.classList.remove('over'));
  zone.addEventListener('drop', (event) => { event.preventDefault(); upload(event.dataTransfer.files); });
  at('files').addEventListener('change', (event) => upload(event.target.files));
}

// ---------------------------------------------------------------- question

// Does what a form asks for.
function submitting(form, told, act) {
  form.addEventListener('submit', async (event) => {
    event.preventDefault(); clearMarks();
    try { await act(new FormData(form)); } catch (error) { blame(error, told); }
  });
}

function gateForm(form) {
  submitting(form, at('gate-told'), async (data) => {
    const query = new URLSearchParams({ name: data.get('name') });
    for (const key of ['baseline', 'no_worse']) if (data.get(key)) query.set(key, data.get(key));
    const { json } = await asked(`/v1/gates?${query}`, data.get('text'), 'application/toml');
    location.href = `/gates/${json.id}`;
  });
}

function gateRunning(section) {
  const bar = section.querySelector('progress');
  const events = new EventSource(section.dataset.events);
  events.addEventListener('progress', (event) => { bar.value = JSON.parse(event.data).decided; });
  events.addEventListener('done', () => { events.close(); location.reload(); });
}

function designForm(form) {
  showNumbers(form);
  submitting(form, at('design-told'), async (data) => {
    const name = data.get('name').trim();
    const odd = [...name].find((letter) => !/[A-Za-z0-9._-]/.test(letter));
    if (!name) throw wrong('name', 'Give the design a name.');
    if (odd) throw wrong('name', `${odd === ' ' ? 'A blank' : `“${odd}”`} does not fit a name. Use a to z, digits, “.”, “-” and “_”.`);
    const body = { name, set: changesIn(form) };
    if (data.get('base')) body.design = data.get('base');
    await asked('/v1/designs', body);
    location.reload();
  });
}

function pairButton(button) {
  button.addEventListener('click', async () => {
    button.disabled = true; at('pair-told').textContent = '';
    try { location.href = `/verdicts/${(await judged(JSON.parse(button.dataset.asking))).report_id}`; } catch (error) { at('pair-told').textContent = worded(error.message); button.disabled = false; }
  });
}

const doings = { reading: 'Reads the recording.', judging: 'Judges the levers.', advising: 'Searches the advice.', reporting: 'Draws the report.' };
const lasting = (seconds) => (seconds < 59.5 ? `${Math.max(1, Math.round(seconds))} s` : `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`);

// Says what a job does now.
function doing({ state, behind, doing: step, first_answer: known }) {
  if (state === 'queued') return behind ? `Waits in the queue behind ${behind} ${behind === 1 ? 'other' : 'others'}.` : 'Is next in the queue.';
  const text = doings[step] || 'Begins.';
  return known ? `${known.verdict.toUpperCase()}. ${worded(known.headline)} ${text}` : text;
}

// Shows in its place how far a job is; returns what takes its standings, and what ends it.
function waiting(place) {
  const [bar, status, timer] = place.querySelectorAll('progress, [role=status], [role=timer]');
  let last = {}; let since = performance.now();
  const count = () => {
    const passed = (last.since_s || 0) + (performance.now() - since) / 1000;
    const usually = last.usual_s ? ` Such a verdict usually takes ${lasting(last.usual_s)}${last.state === 'queued' ? ' once it begins' : ''}.` : '';
    timer.textContent = `${lasting(passed)} so far.${usually}`;
  };
  const ticking = setInterval(count, 1000);
  const step = (standing) => {
    last = standing; since = performance.now();
    if (standing.part === null || standing.part === undefined) bar.removeAttribute('value'); else bar.value = standing.part;
    const text = doing(standing);
    if (status.textContent !== text) status.textContent = text;
    count();
  };
  const end = () => { clearInterval(ticking); place.hidden = true; status.textContent = ''; timer.textContent = ''; };
  place.hidden = false; bar.removeAttribute('value');
  return { step, end };
}

// Asks and waits, and says meanwhile how far it is; resolves to the document.
async function judged(body) {
  const shown = waiting(at('judging'));
  try {
    const first = await asked('/v1/verdicts?wait=0', body);
    if (first.status === 200) return first.json;
    shown.step(first.json);
    return await new Promise((resolve, reject) => {
      const events = new EventSource(first.json.events);
      const end = (act) => (event) => { events.close(); act(JSON.parse(event.data)); };
      events.addEventListener('progress', (event) => shown.step(JSON.parse(event.data)));
      events.addEventListener('done', end((data) => asked(data.verdict).then((answer) => resolve(answer.json), reject)));
      events.addEventListener('refused', end((data) => reject(new Error(data.problem.detail))));
      // The browser asks again by itself unless it was refused.
      events.onerror = () => { if (events.readyState === EventSource.CLOSED) reject(new Error('The server does not answer. Check the network, then try again.')); };
    });
  } finally { shown.end(); }
}

function question(form) {
  const search = at('channel-search');
  if (search) {
    const rows = [...at('channels').tBodies[0].rows];
    const find = () => {
      const wanted = search.value.toLowerCase();
      for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
      at('channel-count').textContent = wanted ? `${rows.filter((row) => !row.hidden).length} of ${rows.length}` : '';
      const next = new URLSearchParams(location.search);
      if (search.value) next.set('search', search.value); else next.delete('search');
      history.replaceState(null, '', `${location.pathname}${next.size ? `?${next}` : ''}${location.hash}`);
    };
    search.value = new URLSearchParams(location.search).get('search') || '';
    search.addEventListener('input', find); find();
  }
  showNumbers(form);
  if (location.hash === '#known') tell('This recording was known already.');
  submitting(form, at('judging-told'), async (data) => {
    const request = JSON.parse(form.dataset.request);
    for (const key of ['opens_when', 'filter', 'model', 'siblings']) if (data.get(key)) request[key] = data.get(key);
    const transfer = (data.get('transfer') || '').trim();
    if (transfer) request.transfer = transfer;
    if (data.get('accept')) request.accept = data.get('accept').split(',');
    const velocity = (data.get('velocity_change') || '').trim();
    if (velocity) request.velocity_change = Number.isNaN(Number(velocity)) ? velocity : Number(velocity);
    // What would be taken anyway is not stated: the same question has the same identity by every door.
    const channel = form.querySelector('input[name=channel]:checked');
    if (!channel) throw wrong('channel', 'Choose a channel.');
    if (!channel.defaultChecked) request.channel = channel.value;
    const body = { recording: form.dataset.recording, request };
    if (data.get('design')) body.design = data.get('design');
    const set = changesIn(form);
    if (set.length) body.set = set;
    location.href = `/verdicts/${(await judged(body)).report_id}`;
  });
}

// ---------------------------------------------------------------- what if

// A number with its field and its slider, which goes by the logarithm where the number has no largest value.
function variedNumber(box, changed) {
  const [field, slider] = box.querySelectorAll('input');
  const [low, high] = [Number(box.dataset.low), Number(box.dataset.high)];
  const [there, back] = low > 0
    ? [(value) => Math.log(value / low) / Math.log(high / low), (part) => low * (high / low) ** part]
    : [(value) => value / high, (part) => part * high];
  const follow = (value) => { slider.value = value > 0 ? there(value) : 0; slider.setAttribute('aria-valuetext', `${field.value} ${box.dataset.unit}`); };
  const now = Number(field.value);
  follow(now);
  slider.addEventListener('input', () => {
    field.value = Number(back(Number(slider.value)).toPrecision(3));
    slider.setAttribute('aria-valuetext', `${field.value} ${box.dataset.unit}`);
    changed();
  });
  field.addEventListener('input', changed);
  return {
    field, follow,
    value: () => numberIn(field),
    isChanged: () => Number(numberIn(field)) !== now,
    reset: () => { field.value = now; follow(now); },
    override: () => `${box.dataset.key}=${numberIn(field)}`,
    words: () => `${box.querySelector('label').textContent.replace(/ \[.*/, '').toLowerCase()} ${field.value.trim()} ${box.dataset.unit}`.trim(),
  };
}

function whatIf(section) {
  const [told, card, judge, back] = ['told', 'card', 'judge', 'back'].map((part) => at(`what-if-${part}`));
  const draw = (curve) => at('event')?.dispatchEvent(new CustomEvent('what-if', { detail: curve }));
  const hint = told.textContent;
  let set = []; let running = false; let again = false;
  const body = () => ({ recording: section.dataset.recording, request: JSON.parse(section.dataset.request), design: JSON.parse(section.dataset.design), set });
  const answer = async (words) => {
    if (running) { again = true; return; }
    running = true;
    const headers = { 'content-type': 'application/json', accept: 'text/html' };
    try {
      const answered = await reach('/v1/what-if', { method: 'POST', headers, body: JSON.stringify(body()) });
      if (!answered.ok) throw new Error((await answered.json()).detail);
      card.innerHTML = await answered.text();
      const curve = card.querySelector('script');
      draw(curve && Float64Array.from(JSON.parse(curve.textContent)));
      told.textContent = `${words}: ${card.querySelector('.answer strong').textContent}. ${card.querySelector('.answer span').textContent}`;
    } catch (error) { card.textContent = ''; draw(null); told.textContent = worded(error.message); }
    running = false;
    if (again) { again = false; changed(); }
  };
  const changed = () => {
    clearMarks();
    for (const one of varied) {
      try { one.follow(Number(one.value())); } catch (error) { mark(one.field, error.message); judge.disabled = true; return; }
    }
    const moved = varied.filter((one) => one.isChanged());
    set = moved.map((one) => one.override());
    for (const button of [judge, back]) button.disabled = moved.length === 0;
    if (moved.length > 0) { answer(`With ${moved.map((one) => one.words()).join(', ')}`); return; }
    card.textContent = ''; draw(null); told.textContent = hint;
  };
  const varied = [...section.querySelectorAll('.varied')].map((box) => variedNumber(box, () => changed()));
  back.addEventListener('click', () => { for (const one of varied) one.reset(); changed(); });
  judge.addEventListener('click', async () => {
    judge.disabled = true;
    try { const document = await judged(body()); location.href = `/verdicts/${document.report_id}`; } catch (error) { told.textContent = worded(error.message); judge.disabled = false; }
  });
}

// On paper every finding stands once.
addEventListener('beforeprint', () => { if (document.querySelector('a[href="#all-findings"]')) at('all-findings').open = true; });

if (at('drop')) dropZone(at('drop'));
if (at('ask')) question(at('ask'));
if (at('gate')) gateForm(at('gate'));
if (at('gate-running')) gateRunning(at('gate-running'));
if (at('design')) designForm(at('design'));
if (at('pair')) pairButton(at('pair'));
if (at('what-if')) whatIf(at('what-if'));
