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

// ---------------------------------------------------------------- plots

const ticks = () => ({ stroke: colour('muted'), grid: { stroke: colour('grid'), width: 1 }, ticks: { stroke: colour('grid') } });
const tones = ['first', 'second', 'third', 'fourth'];
const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
// Eight lines differ by colour or dashes.
const drawnAs = (index) => ({ tone: tones[index % 4], dash: dashes[(index + Math.floor(index / 4)) % 4] });
const kinds = { acceleration: 'Acceleration [m/s²]', angle: 'Angle [rad]' };

// Draws limits, the range of the ensemble's peaks and the cursors over a plot.
function marks(levels, range, cursors) {
  return (plot) => {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    ctx.font = `${13 * devicePixelRatio}px sans-serif`; ctx.textAlign = 'left'; ctx.textBaseline = 'alphabetic';
    if (range && range[0] < plot.scales.y.max) {
      const [top, foot] = [plot.valToPos(range[1], 'y', true), plot.valToPos(range[0], 'y', true)];
      ctx.fillStyle = `${colour('unusable')}30`; ctx.fillRect(bbox.left, top, bbox.width, Math.max(2, foot - top));
      ctx.fillStyle = colour('unusable'); ctx.textAlign = 'right';
      ctx.fillText('peaks of 90 % of the scattered levers', bbox.left + bbox.width - 6, Math.max(top - 6, bbox.top + 14 * devicePixelRatio)); ctx.textAlign = 'left';
    }
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

// The columns of a run near an instant, and the row that is nearest to it.
async function nearest(base, time) {
  let columns = { time_s: [] };
  // Samples may lie far apart.
  for (let reach = 0.0005; columns.time_s.length === 0 && reach < 10; reach *= 10) {
    columns = (await asked(`${base}/series?px=8192&t0=${time - reach}&t1=${time + reach}`)).json.columns;
  }
  let best = -1;
  columns.time_s.forEach((value, index) => { if (best < 0 || Math.abs(value - time) < Math.abs(columns.time_s[best] - time)) best = index; });
  return best < 0 ? null : { columns, row: best, time: columns.time_s[best] };
}

const seconds = (time) => (time === null ? '–' : `${digits(time * 1e3, 6)} ms`);
const times = (rows) => { at('a-time').textContent = seconds(rows.a); at('b-time').textContent = seconds(rows.b); at('d-time').textContent = rows.a !== null && rows.b !== null ? `Δt ${seconds(rows.b - rows.a)}` : '–'; };

// Two plots on one axis of time with zoom and two cursors, in the page's address. `source` reads a
// range, says which lines there are, tells the cursors, and keeps what else belongs into the address.
async function stage(section, source) {
  const query = new URLSearchParams(location.search);
  const number = (name) => (query.get(name) && Number.isFinite(Number(query.get(name))) ? Number(query.get(name)) : null);
  const state = { t0: number('t0'), t1: number('t1'), a: number('a'), b: number('b'), last: 'a' };
  const host = at('motion');
  let whole = null; let shown = null; let plots = [];
  const width = () => Math.max(320, host.clientWidth);
  const keep = () => {
    const next = new URLSearchParams(location.search);
    for (const name of ['t0', 't1', 'a', 'b']) if (state[name] === null) next.delete(name); else next.set(name, String(state[name]));
    source.keep(next);
    const text = next.toString();
    history.replaceState(null, '', text ? `?${text}` : location.pathname);
  };
  const draw = () => {
    for (const plot of plots) plot.destroy();
    plots = Object.keys(kinds).map((kind) => {
      const isAngle = kind === 'angle';
      const data = [shown.time_s]; const series = [{ label: 'Time [s]' }]; const bands = [];
      for (const line of source.lines(kind, shown)) {
        data.push(line.values);
        series.push({ label: line.label, stroke: colour(line.tone), dash: line.dash, width: isAngle ? 2 : 1.25, spanGaps: true, points: { show: false } });
        if (line.error > 0) {
          bands.push({ series: [data.length, data.length + 1], fill: `${colour(line.tone)}30` });
          data.push(line.values.map((value) => value + line.error), line.values.map((value) => value - line.error));
          for (const side of ['+', '−']) series.push({ label: `${side} uncertainty`, class: 'quiet', width: 0, stroke: 'transparent', points: { show: false } });
        }
      }
      const levels = isAngle ? source.limits.map((value) => ({ value, text: `limit ${digits(value)} rad` })) : [];
      const top = Math.max(0, ...source.limits) * 1.15;
      return new uPlot({
        width: width(), height: isAngle ? 280 : 220, series, bands,
        scales: { x: { time: false }, y: isAngle ? { range: (_, low, high) => [Math.min(low, 0), Math.max(Math.min(high, Math.PI / 2), top)] } : {} },
        axes: [{ ...ticks(), label: source.axis || 'Time [s]' }, { ...ticks(), size: 70, label: kinds[kind] }],
        legend: { markers: { dash: (plot, index) => ['solid', 'dashed', 'dotted', 'dashed'][Math.max(0, dashes.findIndex((dash) => String(dash) === String(plot.series[index].dash || [])))] } },
        cursor: { sync: { key: 'motion' }, drag: { x: true, y: false, setScale: false } },
        hooks: { draw: [marks(levels, isAngle ? source.range : null, state)], setSelect: [(plot) => { if (plot.select.width > 4) go(plot.posToVal(plot.select.left, 'x'), plot.posToVal(plot.select.left + plot.select.width, 'x')); }] },
      }, data, at(`plot-${kind}`));
    });
  };
  let reads = 0;
  const read = async () => {
    reads += 1; const own = reads;
    const found = await source.read(state.t0 === null ? null : [state.t0, state.t1], width());
    if (own === reads) shown = found;
  };
  const go = async (t0, t1) => { state.t0 = t0; state.t1 = t1; await read(); keep(); draw(); };
  const span = () => [state.t0 ?? whole[0], state.t1 ?? whole[1]];
  const zoom = (factor) => { const [from, to] = span(); const middle = state[state.last] ?? (from + to) / 2; return go(Math.max(whole[0], middle - (middle - from) * factor), Math.min(whole[1], middle + (to - middle) * factor)); };
  const put = (name, time) => { state[name] = time; state.last = name; keep(); for (const plot of plots) plot.redraw(); return source.tell(state); };
  const hovered = () => { const plot = plots.find((candidate) => candidate.cursor.left > 0); const [from, to] = span(); return plot ? plot.posToVal(plot.cursor.left, 'x') : (from + to) / 2; };
  const save = (ending, blob) => { const link = document.createElement('a'); link.href = URL.createObjectURL(blob); link.download = `latchgate-${source.name}.${ending}`; link.click(); setTimeout(() => URL.revokeObjectURL(link.href), 1000); };
  const acts = {
    a: () => put('a', hovered()), b: () => put('b', hovered()),
    clear: () => { state.a = null; return put('b', null); },
    in: () => zoom(0.5), out: () => zoom(2), whole: () => go(null, null),
    csv: () => { const [from, to] = span(); location.href = `${section.dataset.base}/series.csv?t0=${from}&t1=${to}`; },
    link: () => navigator.clipboard.writeText(location.href).then(() => tell('The link is copied.'), () => tell(location.href)),
    png: () => {
      const parts = plots.map((plot) => plot.ctx.canvas);
      const canvas = Object.assign(document.createElement('canvas'), { width: Math.max(...parts.map((part) => part.width)), height: parts.reduce((sum, part) => sum + part.height, 0) });
      const ctx = canvas.getContext('2d'); let top = 0;
      ctx.fillStyle = colour('paper'); ctx.fillRect(0, 0, canvas.width, canvas.height);
      for (const part of parts) { ctx.drawImage(part, 0, top); top += part.height; }
      canvas.toBlob((blob) => save('png', blob));
    },
    svg: () => save('svg', new Blob([drawn(shown, source, state)], { type: 'image/svg+xml' })),
  };
  section.addEventListener('click', (event) => { const act = acts[event.target.dataset && event.target.dataset.do]; if (act) act(); });
  host.addEventListener('keydown', (event) => {
    const [from, to] = span();
    const step = (to - from) / (event.shiftKey ? 20 : 200);
    const keys = {
      a: acts.a, b: acts.b, '+': acts.in, '-': acts.out, 0: acts.whole,
      ArrowLeft: () => put(state.last, (state[state.last] ?? hovered()) - step), ArrowRight: () => put(state.last, (state[state.last] ?? hovered()) + step),
    };
    if (keys[event.key] && !event.ctrlKey && !event.metaKey) { event.preventDefault(); keys[event.key](); }
  });
  const again = async () => {
    const all = await source.read(null, 2);
    whole = [all.time_s[0], all.time_s.at(-1)];
    await read(); keep(); draw(); await source.tell(state);
  };
  const redraw = () => { keep(); draw(); return source.tell(state); };
  await again();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  let waiting = 0;
  addEventListener('resize', () => { clearTimeout(waiting); waiting = setTimeout(() => { for (const plot of plots) plot.setSize({ width: width(), height: plot.height }); }, 100); });
  section.dataset.ready = 'yes';
  return { again, redraw };
}

async function motion(section) {
  const { base, run, report } = section.dataset;
  const errors = JSON.parse(section.dataset.errors);
  const hidden = new Set((new URLSearchParams(location.search).get('hide') || '').split(',').filter(Boolean));
  const stays = (names) => names.filter((name) => !hidden.has(name));
  const own = (kind, columns) => Object.keys(columns).filter((name) => name.startsWith(`${kind}_`));
  const cell = (name, row, before) => {
    at(`${name}-angle`).textContent = row ? `${before}${degrees(row.angle)}` : '–';
    at(`${name}-acceleration`).textContent = row ? `${digits(row.acceleration)} m/s²` : '–';
  };
  const source = {
    name: report.slice(0, 8), limits: [Number(section.dataset.limit)], range: JSON.parse(section.dataset.range),
    read: async (range, px) => (await asked(`${base}/series?px=${px}${range ? `&t0=${range[0]}&t1=${range[1]}` : ''}`)).json.columns,
    lines: (kind, columns) => stays(own(kind, columns)).map((name) => {
      const index = own(kind, columns).indexOf(name);
      return { label: readable(name), values: columns[name], error: errors[name] || 0, ...(kind === 'angle' ? drawnAs(index) : { tone: ['muted', 'ink'][index % 2], dash: [] }) };
    }),
    keep: (next) => { if (hidden.size) next.set('hide', [...hidden].join(',')); else next.delete('hide'); },
    tell: async (state) => {
      const rows = {};
      for (const name of ['a', 'b']) {
        const near = state[name] === null ? null : await nearest(base, state[name]);
        // Of several runs the cursors read the nominal one, unless that is not shown.
        const angles = near ? own('angle', near.columns) : [];
        const angle = stays([run, ...angles]).find((column) => angles.includes(column)) || angles[0];
        if (angle) at('cursor-angle').textContent = readable(angle).replace(' [rad]', '');
        rows[name] = near && { time: near.time, angle: near.columns[angle][near.row], acceleration: near.columns.acceleration_used_m_s2[near.row] };
        cell(name, rows[name], '');
      }
      const { a, b } = rows;
      times({ a: a && a.time, b: b && b.time });
      cell('d', a && b && { angle: b.angle - a.angle, acceleration: b.acceleration - a.acceleration }, 'Δφ ');
    },
  };
  const { redraw } = await stage(section, source);
  const columns = Object.keys(await source.read(null, 2));
  for (const name of columns.filter((column) => /^(angle|acceleration)_/.test(column))) {
    const label = document.createElement('label'); const box = document.createElement('input');
    box.type = 'checkbox'; box.checked = !hidden.has(name);
    box.addEventListener('change', () => { if (box.checked) hidden.delete(name); else hidden.add(name); redraw(); });
    label.append(box, ` ${readable(name)}`); at('columns').append(label);
  }
}

// Draws what is visible of every plot as SVG, by itself.
function drawn(shown, source, state) {
  const [w, h, left, bottom] = [900, 360, 90, 40];
  const time = shown.time_s; const escaped = (text) => text.replace(/[<>&]/g, (c) => `&#${c.charCodeAt(0)};`);
  const text = (x, y, words, tone, more = '') => `<text x="${x}" y="${y}" fill="${colour(tone)}" ${more}>${escaped(words)}</text>`;
  const panel = (kind, number) => {
    const isAngle = kind === 'angle'; const limits = isAngle ? source.limits : []; const lines = source.lines(kind, shown);
    const top = number * h + 20 + 18 * lines.length; const foot = (number + 1) * h - bottom;
    const values = lines.flatMap((line) => line.values).filter(Number.isFinite);
    const most = values.reduce((high, value) => Math.max(high, value), 0);
    const high = Math.max(...limits.map((limit) => limit * 1.15), isAngle ? Math.min(Math.PI / 2, most) : most);
    const low = values.reduce((least, value) => Math.min(least, value), 0);
    const x = (t) => (left + (w - left - 10) * (t - time[0]) / (time.at(-1) - time[0] || 1)).toFixed(2);
    const y = (v) => (foot - (foot - top) * (v - low) / (high - low || 1)).toFixed(2);
    const line = (path, tone, more = '') => `<path d="${path}" fill="none" stroke="${colour(tone)}" ${more}/>`;
    const clip = `clip-path="url(#part-${number})"`;
    const parts = [`<clipPath id="part-${number}"><rect x="${left}" y="${top}" width="${w - left - 10}" height="${foot - top}"/></clipPath>`];
    lines.forEach(({ label, tone, dash, values: own }, index) => {
      const points = time.map((t, k) => (Number.isFinite(own[k]) ? `${x(t)},${y(own[k])}` : '')).join(' ');
      const look = `stroke-width="2" stroke-dasharray="${dash}"`; const row = number * h + 20 + 18 * index;
      parts.push(`<polyline ${clip} fill="none" stroke="${colour(tone)}" ${look} points="${points}"/>`, line(`M${left} ${row - 5}h30`, tone, look), text(left + 38, row, label, 'ink'));
    });
    for (const limit of limits) parts.push(line(`M${left} ${y(limit)}H${w - 10}`, 'fail', 'stroke-dasharray="9 4"'), text(w - 14, Number(y(limit)) - 6, `limit ${digits(limit)} rad`, 'fail', 'text-anchor="end"'));
    for (const name of ['a', 'b']) if (state[name] !== null && state[name] >= time[0] && state[name] <= time.at(-1)) parts.push(line(`M${x(state[name])} ${top}V${foot}`, 'ink'), text(x(state[name]), top + 14, name.toUpperCase(), 'ink'));
    parts.push(line(`M${left} ${top}V${foot}H${w - 10}`, 'muted'), text(left - 6, top + 10, digits(high), 'muted', 'text-anchor="end"'), text(left - 6, foot, digits(low), 'muted', 'text-anchor="end"'));
    parts.push(text(20, (top + foot) / 2, kinds[kind], 'ink', `text-anchor="middle" transform="rotate(-90 20 ${(top + foot) / 2})"`));
    parts.push(text(left, foot + 18, `${digits(time[0], 6)} s`, 'muted'), text(w - 10, foot + 18, `${digits(time.at(-1), 6)} s`, 'muted', 'text-anchor="end"'));
    return parts.join('');
  };
  const panels = Object.keys(kinds).map(panel);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${w} ${h * panels.length}" font-family="sans-serif" font-size="14"><rect width="${w}" height="${h * panels.length}" fill="${colour('paper')}"/>${panels.join('')}</svg>`;
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

// The first instant at which the acceleration reaches a level, exactly; null if it never does.
async function trigger(base, level) {
  let range = '';
  for (let look = 0; look < 3; look += 1) {
    const { columns, thinned } = (await asked(`${base}/series?px=4096${range}`)).json;
    const first = columns.acceleration_used_m_s2.findIndex((value) => Math.abs(value) >= level);
    if (first < 0) return null;
    if (!thinned) return columns.time_s[first];
    // Of a piece of the record only the extremes are known: look into it.
    range = `&t0=${columns.time_s[Math.max(0, first - 1)]}&t1=${columns.time_s[Math.min(columns.time_s.length - 1, first + 2)]}`;
  }
  return null;
}

async function compare(section) {
  const runs = JSON.parse(section.dataset.runs);
  const box = at('show-all');
  const show = () => { for (const row of document.querySelectorAll('tr.same')) row.hidden = !box.checked; localStorage.setItem('latchgate-show-all', box.checked ? '1' : ''); };
  box.checked = localStorage.getItem('latchgate-show-all') === '1';
  box.addEventListener('change', show); show();
  const query = new URLSearchParams(location.search);
  const align = at('align'); const level = at('level');
  const offsets = runs.map((_, index) => Number(query.get(`o${index}`)) || 0);
  align.value = query.get('align') || 'zero';
  level.value = query.get('level') || level.value;
  let zeros = runs.map(() => 0);
  const base = (run) => `/v1/verdicts/${run.id}`;
  const aligned = async () => {
    level.closest('label').hidden = align.value !== 'trigger';
    at('offsets').hidden = align.value !== 'hand';
    const found = align.value === 'trigger' ? await Promise.all(runs.map((run) => trigger(base(run), Number(level.value)))) : [];
    const never = runs.filter((_, index) => found[index] === null);
    at('align-told').textContent = never.length ? `Never reached, so left at time zero: ${never.map((run) => run.name).join('; ')}` : '';
    zeros = runs.map((run, index) => ({ zero: 0, release: run.release_s, trigger: found[index], hand: offsets[index] })[align.value] ?? 0);
  };
  const columnsOf = (index) => [`acceleration ${index}`, `angle ${index}`];
  const source = {
    name: 'compare', limits: [...new Set(runs.map((run) => run.limit))], range: null, axis: 'Time since each run\'s zero [s]',
    read: async (range, px) => {
      const tables = await Promise.all(runs.map(async (run, index) => {
        const part = range ? `&t0=${range[0] + zeros[index]}&t1=${range[1] + zeros[index]}` : '';
        const { columns } = (await asked(`${base(run)}/series?px=${px}${part}`)).json;
        const nothing = columns.time_s.map(() => null);
        return [columns.time_s.map((time) => time - zeros[index]), columns.acceleration_used_m_s2 || nothing, columns[run.column] || nothing];
      }));
      const [time, ...rest] = uPlot.join(tables);
      const shown = { time_s: time };
      runs.forEach((_, index) => columnsOf(index).forEach((name, side) => { shown[name] = rest[2 * index + side]; }));
      return shown;
    },
    lines: (kind, shown) => runs.map((run, index) => ({ label: run.name, values: shown[`${kind} ${index}`], error: 0, ...drawnAs(index) })),
    keep: (next) => {
      next.set('align', align.value); next.set('level', level.value);
      offsets.forEach((offset, index) => next.set(`o${index}`, String(offset)));
    },
    tell: async (state) => {
      times(state);
      await Promise.all(runs.map(async (run, index) => {
        const rows = {};
        for (const name of ['a', 'b']) {
          const near = state[name] === null ? null : await nearest(base(run), state[name] + zeros[index]);
          const angle = near && near.columns[run.column];
          rows[name] = angle ? angle[near.row] : null;
          at(`${name}-angle-${index}`).textContent = angle ? degrees(rows[name]) : '–';
          at(`${name}-acceleration-${index}`).textContent = near ? `${digits(near.columns.acceleration_used_m_s2[near.row])} m/s²` : '–';
        }
        at(`d-angle-${index}`).textContent = rows.a !== null && rows.b !== null ? degrees(rows.b - rows.a) : '–';
      }));
    },
  };
  let staged = null;
  let turn = 0;
  // Of several changes at once the last one counts.
  const again = async () => {
    turn += 1; const own = turn;
    section.dataset.ready = 'no';
    await aligned();
    if (own === turn) await staged.again();
    if (own === turn) section.dataset.ready = 'yes';
  };
  runs.forEach((run, index) => {
    const label = document.createElement('label'); const input = document.createElement('input');
    input.type = 'number'; input.step = '0.0005'; input.value = String(offsets[index]);
    input.addEventListener('change', () => { offsets[index] = Number(input.value); again(); });
    label.append(`Zero of ${run.name} [s] `, input); at('offsets').append(label);
  });
  for (const field of [align, level]) field.addEventListener('change', again);
  await aligned();
  staged = await stage(section, source);
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
