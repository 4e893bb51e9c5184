// The page's own module: upload, questions, what-if.
const at = (id) => document.getElementById(id);
const tell = (text) => { at('told').textContent = text; setTimeout(() => { at('told').textContent = ''; }, 4000); };

async function asked(path, body, kind = 'application/json') {
  const answer = await fetch(path, body === undefined ? {} : { method: 'POST', headers: { 'content-type': kind }, body: typeof body === 'string' ? body : JSON.stringify(body) });
  const json = await answer.json();
  if (!answer.ok) throw new Error(json.detail || answer.statusText);
  return { status: answer.status, json };
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
  request.onerror = () => { bar.hidden = true; told.textContent = 'The upload was cut; try again.'; };
  request.onload = () => {
    bar.hidden = true;
    const { response, status } = request;
    if (status === 200 || status === 201) {
      told.textContent = status === 200 ? 'Known already.' : 'Kept.';
      location.href = `/recordings/${response.id}${status === 200 ? '#known' : ''}`;
    } else told.textContent = (response && response.detail) || `Refused (${status}).`;
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

const listed = (text) => text.split(',').map((part) => part.trim()).filter(Boolean);

// Does what a form asks for; what is in the way is told beside it.
function submitting(form, told, act) {
  form.addEventListener('submit', async (event) => {
    event.preventDefault(); told.textContent = '';
    try { await act(new FormData(form)); } catch (error) { told.textContent = error.message; }
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
  submitting(form, at('design-told'), async (data) => {
    const body = { name: data.get('name'), set: listed(data.get('set')) };
    if (data.get('base')) body.design = data.get('base');
    await asked('/v1/designs', body);
    location.reload();
  });
}

function pairButton(button) {
  button.addEventListener('click', async () => {
    button.disabled = true; at('pair-told').textContent = 'It is judged …';
    try { location.href = `/verdicts/${(await judged(JSON.parse(button.dataset.asking), () => {})).report_id}`; } catch (error) { at('pair-told').textContent = error.message; button.disabled = false; }
  });
}

// Asks and waits; resolves to the document.
async function judged(body, step) {
  const first = await asked('/v1/verdicts?wait=1', body);
  if (first.status === 200) return first.json;
  return new Promise((resolve, reject) => {
    const events = new EventSource(first.json.events);
    const end = (act) => (event) => { events.close(); act(JSON.parse(event.data)); };
    events.addEventListener('progress', (event) => step(JSON.parse(event.data).part));
    events.addEventListener('done', end((data) => asked(data.verdict).then((answer) => resolve(answer.json), reject)));
    events.addEventListener('refused', end((data) => reject(new Error(data.problem.detail))));
    events.onerror = () => step(null);
  });
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
  const design = form.elements.design;
  const differences = () => { at('design-differences').textContent = design.selectedOptions[0].dataset.differences ? `Differs from the paper's lever: ${design.selectedOptions[0].dataset.differences}` : ''; };
  design.addEventListener('change', differences); differences();
  if (location.hash === '#known') tell('This recording was known already.');
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    const bar = at('judging'); const told = at('judging-told');
    const data = new FormData(form);
    const request = JSON.parse(form.dataset.request);
    for (const key of ['opens_when', 'filter', 'model']) if (data.get(key)) request[key] = data.get(key);
    // What would be taken anyway is not stated: the same question has the same identity by every door.
    const channel = form.querySelector('input[name=channel]:checked');
    if (channel && !channel.defaultChecked) request.channel = channel.value;
    const body = { recording: form.dataset.recording, request };
    if (data.get('design')) body.design = data.get('design');
    const set = listed(data.get('set'));
    if (set.length) body.set = set;
    bar.hidden = false; told.textContent = '';
    try {
      const document = await judged(body, (part) => { if (part === null || part === undefined) bar.removeAttribute('value'); else bar.value = part; });
      location.href = `/verdicts/${document.report_id}`;
    } catch (error) { told.textContent = error.message; }
    bar.hidden = true;
  });
}

// ---------------------------------------------------------------- what if

function whatIf(section) {
  const told = at('what-if-told'); const button = at('what-if-judge');
  const sliders = [...section.querySelectorAll('input[type=range]')];
  const body = () => ({
    recording: section.dataset.recording, request: JSON.parse(section.dataset.request), design: JSON.parse(section.dataset.design),
    set: sliders.filter((slider) => slider.value !== slider.defaultValue).map((slider) => `${slider.dataset.key}=${slider.value}`),
  });
  let running = false; let again = false;
  const answer = async () => {
    if (running) { again = true; return; }
    running = true;
    const headers = { 'content-type': 'application/json', accept: 'text/html' };
    try {
      const answered = await fetch('/v1/what-if', { method: 'POST', headers, body: JSON.stringify(body()) });
      if (answered.ok) told.innerHTML = await answered.text();
      else told.textContent = (await answered.json()).detail;
    } catch (error) { told.textContent = error.message; }
    running = false;
    if (again) { again = false; answer(); }
  };
  for (const slider of sliders) slider.addEventListener('input', () => {
    const output = slider.nextElementSibling;
    output.textContent = `${Number(Number(slider.value).toPrecision(4))} ${slider.dataset.unit}`;
    button.disabled = false;
    answer();
  });
  button.addEventListener('click', async () => {
    button.disabled = true; told.textContent = 'The varied levers are asked …';
    try { const document = await judged(body(), () => {}); location.href = `/verdicts/${document.report_id}`; } catch (error) { told.textContent = error.message; button.disabled = false; }
  });
}

if (at('drop')) dropZone(at('drop'));
if (at('ask')) question(at('ask'));
if (at('gate')) gateForm(at('gate'));
if (at('gate-running')) gateRunning(at('gate-running'));
if (at('design')) designForm(at('design'));
if (at('pair')) pairButton(at('pair'));
if (at('what-if')) whatIf(at('what-if'));
