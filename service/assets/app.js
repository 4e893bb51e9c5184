// The page's own module: upload, questions, plots with two cursors, what-if, compare.
const at = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const tell = (text) => { at('told').textContent = text; setTimeout(() => { at('told').textContent = ''; }, 4000); };
const digits = (value, count = 4) => (Number.isFinite(value) ? String(Number(value.toPrecision(count))).replace('-', '−') : '–');
const degrees = (radians) => (Math.abs(radians) > Math.PI / 2 ? '> 90°' : `${digits(radians)} rad (${digits(radians * 180 / Math.PI, 3)}°)`);

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
  if (search) search.addEventListener('input', () => {
    const wanted = search.value.toLowerCase();
    for (const row of at('channels').tBodies[0].rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
  });
  const design = form.elements.design;
  const differences = () => { at('design-differences').textContent = design.selectedOptions[0].dataset.differences ? `Differs from the paper's lever: ${design.selectedOptions[0].dataset.differences}` : ''; };
  design.addEventListener('change', differences); differences();
  if (location.hash === '#known') tell('This recording was known already.');
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    const bar = at('judging'); const told = at('judging-told');
    const data = new FormData(form);
    const request = JSON.parse(form.dataset.request);
    for (const key of ['channel', 'opens_when', 'filter', 'model']) if (data.get(key)) request[key] = data.get(key);
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

// ---------------------------------------------------------------- plots

const ticks = () => ({ stroke: colour('muted'), grid: { stroke: colour('grid'), width: 1 }, ticks: { stroke: colour('grid') } });
const tones = ['first', 'second', 'third', 'fourth'];
const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

// Draws a level line and the cursors over a plot.
function marks(levels, cursors) {
  return (plot) => {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    ctx.font = `${13 * devicePixelRatio}px sans-serif`; ctx.textAlign = 'left'; ctx.textBaseline = 'alphabetic';
    for (const { value, text } of levels) {
      const y = plot.valToPos(value, 'y', true);
      ctx.strokeStyle = colour('fail'); ctx.fillStyle = colour('fail'); ctx.lineWidth = 1.75 * devicePixelRatio;
      ctx.setLineDash([9 * devicePixelRatio, 4 * devicePixelRatio]);
      ctx.beginPath(); ctx.moveTo(bbox.left, y); ctx.lineTo(bbox.left + bbox.width, y); ctx.stroke();
      ctx.fillText(text, bbox.left + 6, y - 6);
    }
    ctx.setLineDash([]);
    for (const name of ['a', 'b']) {
      if (cursors[name] === null) continue;
      const x = plot.valToPos(cursors[name], 'x', true);
      ctx.strokeStyle = colour('ink'); ctx.fillStyle = colour('ink'); ctx.lineWidth = devicePixelRatio;
      ctx.beginPath(); ctx.moveTo(x, bbox.top); ctx.lineTo(x, bbox.top + bbox.height); ctx.stroke();
      ctx.fillText(name.toUpperCase(), x + 4, bbox.top + 14 * devicePixelRatio);
    }
    ctx.restore();
  };
}

function readable(column) {
  const parts = column.match(/^angle_(\w+)_(\w+)_rad$/);
  if (parts) return `Angle, ${parts[1]} stop, opens when ${parts[2]} [rad]`;
  return { acceleration_recorded_m_s2: 'Acceleration as recorded [m/s²]', acceleration_used_m_s2: 'Acceleration as used [m/s²]', velocity_m_s: 'Velocity [m/s]' }[column] || column;
}

async function motion(section) {
  const { base } = section.dataset;
  const limit = Number(section.dataset.limit); const error = Number(section.dataset.error);
  const query = new URLSearchParams(location.search);
  const number = (name) => (query.has(name) && query.get(name) !== '' && Number.isFinite(Number(query.get(name))) ? Number(query.get(name)) : null);
  const state = { t0: number('t0'), t1: number('t1'), a: number('a'), b: number('b'), hidden: new Set((query.get('hide') || '').split(',').filter(Boolean)), last: 'a' };
  let whole = null; let shown = null; let plots = [];
  const width = () => Math.max(320, at('motion').clientWidth);

  const fetched = async () => {
    const range = state.t0 === null ? '' : `&t0=${state.t0}&t1=${state.t1}`;
    const { json } = await asked(`${base}/series?px=${width()}${range}`);
    return json.columns;
  };
  const keep = () => {
    const next = new URLSearchParams();
    for (const name of ['t0', 't1', 'a', 'b']) if (state[name] !== null) next.set(name, String(state[name]));
    if (state.hidden.size) next.set('hide', [...state.hidden].join(','));
    const text = next.toString();
    history.replaceState(null, '', text ? `?${text}` : location.pathname);
  };
  // The row at or before an instant, exactly.
  const exact = async (time) => {
    const { json } = await asked(`${base}/series?px=8192&t0=${time - 0.0005}&t1=${time + 0.0005}`);
    const found = json.columns.time_s; let best = -1;
    found.forEach((value, index) => { if (best < 0 || Math.abs(value - time) < Math.abs(found[best] - time)) best = index; });
    if (best < 0) return null;
    // Of several runs the cursors read the nominal one, unless that is not shown.
    const angles = Object.keys(json.columns).filter((name) => name.startsWith('angle_'));
    const angle = [section.dataset.run, ...angles].find((name) => angles.includes(name) && !state.hidden.has(name)) || angles[0];
    at('cursor-angle').textContent = readable(angle).replace(' [rad]', '');
    return { time: found[best], angle: json.columns[angle][best], acceleration: json.columns.acceleration_used_m_s2[best] };
  };
  const table = async () => {
    const rows = {};
    for (const name of ['a', 'b']) {
      rows[name] = state[name] === null ? null : await exact(state[name]);
      const row = rows[name];
      at(`${name}-time`).textContent = row ? `${digits(row.time * 1e3, 6)} ms` : '–';
      at(`${name}-angle`).textContent = row ? degrees(row.angle) : '–';
      at(`${name}-acceleration`).textContent = row ? `${digits(row.acceleration)} m/s²` : '–';
    }
    const both = rows.a && rows.b;
    at('d-time').textContent = both ? `Δt ${digits((rows.b.time - rows.a.time) * 1e3, 6)} ms` : '–';
    at('d-angle').textContent = both ? `Δφ ${degrees(rows.b.angle - rows.a.angle)}` : '–';
    at('d-acceleration').textContent = both ? `${digits(rows.b.acceleration - rows.a.acceleration)} m/s²` : '–';
  };
  const draw = () => {
    for (const plot of plots) plot.destroy();
    plots = ['acceleration', 'angle'].map((kind) => {
      const names = Object.keys(shown).filter((name) => name.startsWith(`${kind}_`) && !state.hidden.has(name));
      const data = [shown.time_s]; const series = [{ label: 'Time [s]' }]; const bands = [];
      names.forEach((name, index) => {
        data.push(shown[name]);
        series.push({ label: readable(name), stroke: colour(kind === 'angle' ? tones[index % 4] : ['muted', 'ink'][index % 2]), width: kind === 'angle' ? 2 : 1.25, dash: kind === 'angle' ? dashes[index % 4] : [], points: { show: false } });
        if (kind === 'angle' && error > 0) {
          const at0 = data.length;
          data.push(shown[name].map((value) => value + error), shown[name].map((value) => value - error));
          for (const side of ['+', '−']) series.push({ label: `${side} uncertainty`, class: 'quiet', width: 0, stroke: 'transparent', points: { show: false } });
          bands.push({ series: [at0, at0 + 1], fill: `${colour(tones[index % 4])}30` });
        }
      });
      const levels = kind === 'angle' ? [{ value: limit, text: `limit ${digits(limit)} rad` }] : [];
      return new uPlot({
        width: width(), height: kind === 'angle' ? 280 : 220, series, bands,
        scales: { x: { time: false }, y: kind === 'angle' ? { range: (_, low, high) => [Math.min(low, 0), Math.max(Math.min(high, Math.PI / 2), limit * 1.15)] } : {} },
        axes: [{ ...ticks(), label: 'Time [s]', stroke: colour('muted') }, { ...ticks(), size: 70, label: kind === 'angle' ? 'Angle [rad]' : 'Acceleration [m/s²]' }],
        cursor: { sync: { key: 'motion' }, drag: { x: true, y: false, setScale: false } },
        legend: { live: true, markers: { show: true } },
        hooks: { draw: [marks(levels, state)], setSelect: [(plot) => { if (plot.select.width > 4) go(plot.posToVal(plot.select.left, 'x'), plot.posToVal(plot.select.left + plot.select.width, 'x')); }] },
      }, data, at(`plot-${kind}`));
    });
  };
  const go = async (t0, t1) => { state.t0 = t0; state.t1 = t1; shown = await fetched(); keep(); draw(); };
  const span = () => [state.t0 ?? whole[0], state.t1 ?? whole[1]];
  const zoom = (factor) => { const [from, to] = span(); const middle = state[state.last] ?? (from + to) / 2; return go(Math.max(whole[0], middle - (middle - from) * factor), Math.min(whole[1], middle + (to - middle) * factor)); };
  const put = (name, time) => { state[name] = time; state.last = name; keep(); for (const plot of plots) plot.redraw(); return table(); };
  const hovered = () => { const plot = plots.find((candidate) => candidate.cursor.left > 0); const [from, to] = span(); return plot ? plot.posToVal(plot.cursor.left, 'x') : (from + to) / 2; };
  const save = (name, blob) => { const link = document.createElement('a'); link.href = URL.createObjectURL(blob); link.download = name; link.click(); setTimeout(() => URL.revokeObjectURL(link.href), 1000); };
  const acts = {
    a: () => put('a', hovered()), b: () => put('b', hovered()),
    clear: () => { state.a = null; return put('b', null); },
    in: () => zoom(0.5), out: () => zoom(2), whole: () => go(null, null),
    csv: () => { const [from, to] = span(); location.href = `${base}/series.csv?t0=${from}&t1=${to}`; },
    link: () => navigator.clipboard.writeText(location.href).then(() => tell('The link is copied.'), () => tell(location.href)),
    png: () => {
      const parts = plots.map((plot) => plot.ctx.canvas);
      const canvas = Object.assign(document.createElement('canvas'), { width: Math.max(...parts.map((part) => part.width)), height: parts.reduce((sum, part) => sum + part.height, 0) });
      const ctx = canvas.getContext('2d'); let top = 0;
      ctx.fillStyle = colour('paper'); ctx.fillRect(0, 0, canvas.width, canvas.height);
      for (const part of parts) { ctx.drawImage(part, 0, top); top += part.height; }
      canvas.toBlob((blob) => save(`latchgate-${section.dataset.report.slice(0, 8)}.png`, blob));
    },
    svg: () => save(`latchgate-${section.dataset.report.slice(0, 8)}.svg`, new Blob([drawn(shown, state, limit)], { type: 'image/svg+xml' })),
  };
  section.addEventListener('click', (event) => { const act = acts[event.target.dataset && event.target.dataset.do]; if (act) act(); });
  at('motion').addEventListener('keydown', (event) => {
    const [from, to] = span();
    const step = (to - from) / (event.shiftKey ? 20 : 200);
    const keys = {
      a: acts.a, b: acts.b, '+': acts.in, '-': acts.out, 0: acts.whole,
      ArrowLeft: () => put(state.last, (state[state.last] ?? hovered()) - step), ArrowRight: () => put(state.last, (state[state.last] ?? hovered()) + step),
    };
    if (keys[event.key] && !event.ctrlKey && !event.metaKey) { event.preventDefault(); keys[event.key](); }
  });

  const all = (await asked(`${base}/series?px=2`)).json.columns.time_s;
  const summary = await asked(`${base}/series?px=${width()}`);
  whole = [all[0], summary.json.columns.time_s.at(-1)];
  shown = state.t0 === null ? summary.json.columns : await fetched();
  for (const name of Object.keys(shown).filter((column) => /^(angle|acceleration)_/.test(column))) {
    const label = document.createElement('label'); const box = document.createElement('input');
    box.type = 'checkbox'; box.checked = !state.hidden.has(name);
    box.addEventListener('change', () => { if (box.checked) state.hidden.delete(name); else state.hidden.add(name); keep(); draw(); table(); });
    label.append(box, ` ${readable(name)}`); at('columns').append(label);
  }
  draw(); await table();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  let waiting = 0;
  addEventListener('resize', () => { clearTimeout(waiting); waiting = setTimeout(() => { for (const plot of plots) plot.setSize({ width: width(), height: plot.height }); }, 100); });
  section.dataset.ready = 'yes';
}

// Draws the visible range as SVG, by itself.
function drawn(columns, state, limit) {
  const names = Object.keys(columns).filter((name) => name.startsWith('angle_') && !state.hidden.has(name));
  const time = columns.time_s; const [w, h, left, bottom] = [900, 360, 70, 40];
  const values = names.flatMap((name) => columns[name]).filter(Number.isFinite);
  const high = Math.max(limit * 1.15, Math.min(Math.PI / 2, values.reduce((most, value) => Math.max(most, value), 0)));
  const low = values.reduce((least, value) => Math.min(least, value), 0);
  const x = (t) => (left + (w - left - 10) * (t - time[0]) / (time.at(-1) - time[0] || 1)).toFixed(2);
  const y = (v) => (10 + (h - bottom - 10) * (1 - (v - low) / (high - low || 1))).toFixed(2);
  const escaped = (text) => text.replace(/[<>&]/g, (c) => `&#${c.charCodeAt(0)};`);
  const lines = names.map((name, index) => `<polyline fill="none" stroke="${colour(tones[index % 4])}" stroke-width="2" stroke-dasharray="${dashes[index % 4]}" points="${time.map((t, k) => (Number.isFinite(columns[name][k]) ? `${x(t)},${y(columns[name][k])}` : '')).join(' ')}"/><text x="${left + 10}" y="${26 + 18 * index}" fill="${colour(tones[index % 4])}">${escaped(readable(name))}</text>`);
  const cursors = ['a', 'b'].filter((name) => state[name] !== null && state[name] >= time[0] && state[name] <= time.at(-1)).map((name) => `<path d="M${x(state[name])} 10V${h - bottom}" stroke="${colour('ink')}"/><text x="${x(state[name])}" y="22" fill="${colour('ink')}">${name.toUpperCase()}</text>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${w} ${h}" font-family="sans-serif" font-size="14"><rect width="${w}" height="${h}" fill="${colour('paper')}"/>${lines.join('')}<path d="M${left} ${y(limit)}H${w - 10}" stroke="${colour('fail')}" stroke-dasharray="9 4"/><text x="${w - 150}" y="${Number(y(limit)) - 6}" fill="${colour('fail')}">limit ${digits(limit)} rad</text>${cursors.join('')}<path d="M${left} 10V${h - bottom}H${w - 10}" fill="none" stroke="${colour('muted')}"/><text x="${left}" y="${h - 12}" fill="${colour('muted')}">${digits(time[0], 6)} s</text><text x="${w - 90}" y="${h - 12}" fill="${colour('muted')}">${digits(time.at(-1), 6)} s</text></svg>`;
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
    const began = performance.now();
    try {
      const { json } = await asked('/v1/what-if', body());
      const peak = json.nominal ? degrees(json.nominal.peak_angle_rad) : '–';
      told.textContent = `Nominal: ${json.verdict.toUpperCase()} · peak ${peak} · limit ${degrees(json.threshold_rad)}`;
      section.dataset.took = String(Math.round(performance.now() - began));
    } catch (error) { told.textContent = error.message; }
    running = false;
    if (again) { again = false; answer(); }
  };
  for (const slider of sliders) slider.addEventListener('input', () => {
    const output = slider.nextElementSibling;
    output.textContent = `${digits(Number(slider.value))} ${output.textContent.split(' ').at(-1)}`;
    button.disabled = false;
    answer();
  });
  button.addEventListener('click', async () => {
    button.disabled = true; told.textContent = 'The ensemble is asked …';
    try { const document = await judged(body(), () => {}); location.href = `/verdicts/${document.report_id}`; } catch (error) { told.textContent = error.message; button.disabled = false; }
  });
}

// ---------------------------------------------------------------- compare

async function compare(section) {
  const runs = JSON.parse(section.dataset.runs);
  const box = at('show-all');
  const show = () => { for (const row of document.querySelectorAll('tr.same')) row.hidden = !box.checked; localStorage.setItem('latchgate-show-all', box.checked ? '1' : ''); };
  box.checked = localStorage.getItem('latchgate-show-all') === '1';
  box.addEventListener('change', show); show();
  const query = new URLSearchParams(location.search);
  const offsets = runs.map((_, index) => Number(query.get(`o${index}`)) || 0);
  at('align').value = query.get('align') || 'zero';
  let range = query.has('t0') ? [Number(query.get('t0')), Number(query.get('t1'))] : null;
  const shift = (index) => ({ zero: 0, release: runs[index].release_s ?? 0, hand: offsets[index] })[at('align').value];
  const keep = () => { query.set('align', at('align').value); offsets.forEach((offset, index) => query.set(`o${index}`, String(offset))); if (range) { query.set('t0', String(range[0])); query.set('t1', String(range[1])); } else { query.delete('t0'); query.delete('t1'); } history.replaceState(null, '', `?${query}`); };
  runs.forEach((run, index) => {
    const label = document.createElement('label'); const input = document.createElement('input');
    input.type = 'number'; input.step = '0.0005'; input.value = String(offsets[index]);
    input.addEventListener('change', () => { offsets[index] = Number(input.value); at('align').value = 'hand'; keep(); draw(); });
    label.append(`Zero of ${run.name} [s] `, input); at('offsets').append(label);
  });
  let plot = null;
  const draw = async () => {
    const tables = [];
    for (const [index, run] of runs.entries()) {
      const part = range ? `&t0=${range[0] + shift(index)}&t1=${range[1] + shift(index)}` : '';
      const { columns } = (await asked(`/v1/verdicts/${run.id}/series?px=1000${part}`)).json;
      tables.push([columns.time_s.map((time) => time - shift(index)), columns[run.column] || columns.time_s.map(() => null)]);
    }
    const data = uPlot.join(tables, tables.map(() => [2]));
    const limits = [...new Set(runs.map((run) => run.limit))].map((value) => ({ value, text: `limit ${digits(value)} rad` }));
    const top = Math.max(...limits.map((level) => level.value)) * 1.15;
    if (plot) plot.destroy();
    plot = new uPlot({
      width: Math.max(320, at('compare-motion').clientWidth), height: 340, scales: { x: { time: false }, y: { range: (_, low, high) => [Math.min(low, 0), Math.max(Math.min(high, Math.PI / 2), top)] } },
      axes: [{ ...ticks(), label: 'Time [s]' }, { ...ticks(), size: 70, label: 'Angle [rad]' }],
      series: [{ label: 'Time [s]' }, ...runs.map((run, index) => ({ label: run.name, stroke: colour(tones[index % 4]), dash: dashes[index % 4], width: 2, spanGaps: true, points: { show: false } }))],
      cursor: { drag: { x: true, y: false, setScale: false } },
      hooks: { draw: [marks(limits, { a: null, b: null })], setSelect: [(self) => { if (self.select.width > 4) { range = [self.posToVal(self.select.left, 'x'), self.posToVal(self.select.left + self.select.width, 'x')]; keep(); draw(); } }] },
    }, data, at('plot-compare'));
    section.dataset.ready = 'yes';
  };
  at('align').addEventListener('change', () => { keep(); draw(); });
  at('compare-whole').addEventListener('click', () => { range = null; keep(); draw(); });
  at('compare-motion').addEventListener('keydown', (event) => {
    if (!plot || (event.key !== '+' && event.key !== '-')) return;
    const [from, to] = [plot.scales.x.min, plot.scales.x.max]; const half = (to - from) / (event.key === '+' ? 4 : 1);
    range = [(from + to) / 2 - half, (from + to) / 2 + half]; keep(); draw();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  await draw();
}

if (at('drop')) dropZone(at('drop'));
if (at('ask')) question(at('ask'));
if (at('plots')) motion(at('plots')).catch((error) => tell(error.message));
if (at('gate')) gateForm(at('gate'));
if (at('gate-running')) gateRunning(at('gate-running'));
if (at('design')) designForm(at('design'));
if (at('pair')) pairButton(at('pair'));
if (at('what-if')) whatIf(at('what-if'));
if (at('compare')) compare(at('compare')).catch((error) => tell(error.message));
