// The page of the service as a browser shows it: a sample, upload, channel, verdict, cursors, link,
// download, what-if, compare, paper, phone, signing in and out; in light and dark, checked for accessibility,
// without any request elsewhere.
//
// Pictures are written to target/browser/.

import { execFileSync, spawn } from 'node:child_process';
import { strict as assert } from 'node:assert';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { barriers, latchgateProgram, launched, pictures, root, serviceProgram } from './common.mjs';

// Starts a service on a folder of its own.
async function started() {
  const data = mkdtempSync(path.join(tmpdir(), 'latchgate-browser-'));
  const child = spawn(serviceProgram, ['--listen', '127.0.0.1:0', '--data', data, '--set', 'log=warn'], { stdio: ['ignore', 'pipe', 'inherit'] });
  const address = await new Promise((resolve, reject) => {
    child.stdout.once('data', (text) => resolve(String(text).match(/http:\/\/[^/]+/)[0]));
    child.once('exit', () => reject(new Error('the service did not start')));
  });
  const stop = async () => {
    child.kill('SIGTERM');
    await new Promise((resolve) => child.once('exit', resolve));
    rmSync(data, { recursive: true, force: true });
  };
  return { address, data, stop };
}
const service = await started();
const base = service.address;
const browser = await launched();

async function look(page, name) {
  assert.deepEqual(await barriers(page), [], `${name}: accessibility`);
  await page.screenshot({ path: path.join(pictures, `service-${name}.png`), fullPage: true });
}

// A field is marked as wrong, with the reason beside it.
async function marked(field, reason) {
  await field.page().waitForFunction((name) => document.querySelector(`[name="${name}"]`).getAttribute('aria-invalid') === 'true', await field.getAttribute('name'));
  const note = await field.getAttribute('aria-describedby');
  assert.match(await field.page().locator(`[id="${note}"]`).innerText(), reason);
}

async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

// What the page was answered is what the interface, the command line and a gate say of the signal.
async function sameByEveryDoor(page, report) {
  const plain = (text) => { const document = JSON.parse(text); delete document.run; return JSON.stringify(document); };
  const download = await downloaded(page, () => page.getByRole('link', { name: /every digit/ }).click());
  const ask = (address, kind, body) => page.request.post(`${base}${address}`, { headers: { 'content-type': kind }, data: body });
  const { recording } = (await (await page.request.get(`${base}/v1/verdicts`)).json()).verdicts.find((one) => one.report_id === report);
  const served = await ask('/v1/verdicts?wait=60', 'application/json', JSON.stringify({ recording, set: ['lever.preload_torque_nm=2.5'] }));
  const out = mkdtempSync(path.join(tmpdir(), 'latchgate-door-'));
  try {
    execFileSync(latchgateProgram, ['replay', path.join(root, 'signals/burst.csv'), '--set', 'lever.preload_torque_nm=2.5', '--out', path.join(out, 'report')], { stdio: 'pipe' });
  } catch (error) { assert([1, 3].includes(error.status), String(error.stderr)); }
  const written = readFileSync(path.join(out, 'report/verdict.json'), 'utf8');
  rmSync(out, { recursive: true });
  assert.equal(plain(download.bytes), plain(written), 'page and command line');
  assert.equal(plain(await served.text()), plain(written), 'interface and command line');
  const text = `[[recordings]]\nfiles = "${recording}"\n[[designs]]\nset = { "lever.preload_torque_nm" = 2.5 }\n`;
  const { id } = await (await ask('/v1/gates?name=door', 'application/toml', text)).json();
  await page.request.get(`${base}/v1/gates/${id}/events`);
  const summary = await (await page.request.get(`${base}/v1/gates/${id}/summary.json`)).json();
  assert.equal(summary.pairs[0].row.report_id, report, 'gate and page');
}

// A table with a preamble, decimal commas and many channels, dropped on the page: what was found out
// about it is shown, what is overridden is read so, and the search of channels stays in the address.
async function mapped(page, colorScheme) {
  const names = ['Zeit [ms]', ...Array.from({ length: 12 }, (_, number) => `acc_${number < 6 ? 'y' : 'x'}_${number} [g]`)];
  const rows = Array.from({ length: 400 }, (_, row) => [row / 10, ...Array.from({ length: 12 }, (__, column) => Math.sin(row / 20 + column))].map((value) => value.toFixed(4).replace('.', ',')).join(';'));
  const text = `1${colorScheme.length}\nPrüfstand 3\n${names.join(';')}\n${rows.join('\n')}\n`;
  await page.goto(base);
  const dropped = await page.evaluateHandle(([name, content]) => { const data = new DataTransfer(); data.items.add(new File([content], name)); return data; }, [`many-${colorScheme}.csv`, text]);
  for (const kind of ['dragenter', 'dragover', 'drop']) await page.dispatchEvent('#drop', kind, { dataTransfer: dropped });
  await page.waitForURL(/recordings/);
  // A number alone above the names may be a sample, so that is asked about.
  assert.match(await page.locator('#mapping').innerText(), /^It seems: cells separated by semicolon; .*names on line 3, samples from line 4/);
  await look(page, `${colorScheme}-preamble`);
  await page.locator('input[name=header_line]').fill('3');
  await page.getByRole('button', { name: 'Read again' }).click();
  await page.waitForURL(/header_line=3/);
  const found = await page.locator('#mapping').innerText();
  assert.match(found, /separated by semicolon; decimal mark ,; names on line 3, samples from line 4; time in Zeit \[ms\], in ms/);
  assert.match(await page.locator('ol.preview li').nth(2).innerText(), /names$/);
  await page.locator('#channel-search').fill('acc_y');
  await page.waitForFunction(() => document.getElementById('channel-count').textContent === '6 of 12');
  await look(page, `${colorScheme}-mapping`);
  await page.reload();
  assert.equal(await page.locator('#channels tbody tr:visible').count(), 6);
  assert.match(page.url(), /search=acc_y/);
  // What is overridden is read so.
  await page.locator('input[name=time_unit]').fill('s');
  await page.locator('select[name=input_format]').selectOption('csv');
  await page.getByRole('button', { name: 'Read again' }).click();
  await page.waitForURL(/time_unit=s/);
  assert.match(await page.locator('#mapping').innerText(), /time in Zeit \[ms\], in s/);
  assert.match(await page.locator('#channels tbody tr:visible').first().innerText(), /10\.00 Hz/);
  assert.equal(await page.locator('#channels tbody tr:visible').count(), 6);
}

// An empty service offers a sample: one click leads to its verdict, and what is done meanwhile is said in words.
async function sampled(colorScheme) {
  const empty = await started();
  const page = await (await browser.newContext({ colorScheme, viewport: { width: 1200, height: 900 } })).newPage();
  await page.goto(empty.address);
  assert.equal(await page.locator('form.filters').count(), 0);
  await look(page, `${colorScheme}-home-empty`);
  // The job's events are held back, so that the page waits as long as it is looked at.
  let release;
  const held = new Promise((resolve) => { release = resolve; });
  await page.route('**/events', async (route) => { await held; await route.continue(); });
  await page.getByRole('button', { name: 'Judge the sample' }).click();
  await page.waitForFunction(() => /^[2-9] s so far\.$/.test(document.querySelector('#judging [role=timer]').textContent));
  assert.match(await page.locator('#judging [role=status]').innerText(), /^(Waits in the queue behind 1 other|Is next in the queue|Begins|Reads the recording|Judges the levers)\.$/);
  await look(page, `${colorScheme}-waiting`);
  release();
  await page.waitForURL(/verdicts/, { timeout: 120_000 });
  await page.goto(empty.address);
  assert.equal(await page.getByRole('button', { name: 'Judge the sample' }).count(), 0);
  await page.close();
  await empty.stop();
}

async function walk(colorScheme) {
  const context = await browser.newContext({ colorScheme, viewport: { width: 1200, height: 900 }, acceptDownloads: true });
  const page = await context.newPage();
  const odd = [];
  page.on('request', (request) => { if (!request.url().startsWith(base) && !/^(data|blob):/.test(request.url())) odd.push(request.url()); });
  page.on('console', (message) => { if (message.type() === 'error') odd.push(message.text()); });
  page.on('pageerror', (error) => odd.push(String(error)));

  // Upload, with its card.
  await page.goto(base);
  const files = ['burst.csv', 'burst.csv.toml'].map((name) => path.join(root, 'signals', name));
  await page.setInputFiles('#files', files);
  await page.waitForURL(/recordings/);
  await look(page, `${colorScheme}-recording`);
  assert.equal(await page.locator('input[name=channel]:checked').inputValue(), 'acceleration y (g)');
  await page.goto(base);
  await page.setInputFiles('#files', files);
  await page.waitForURL(/#known/);

  await mapped(page, colorScheme);
  await page.goto(`${base}/`);
  await page.setInputFiles('#files', files);
  await page.waitForURL(/#known/);

  // Verdict, by the keyboard alone. What is no number is marked and told beside the field; a decimal comma is taken.
  await page.getByText('Change numbers of the lever').click();
  const preload = page.locator('[name="lever.preload_torque_nm"]');
  assert.equal(await preload.getAttribute('placeholder'), '0.1');
  await preload.fill('strong');
  await preload.press('Enter');
  await marked(preload, /Type a number, as 4.5 or 4,5. Found “strong”/);
  await preload.fill('-3');
  await preload.press('Enter');
  await marked(preload, /^“Preload torque \[N·m\]” must be zero or positive/);
  assert.match(odd.pop(), /status of 400/);
  await look(page, `${colorScheme}-marked`);
  // Without a network it says so in plain words.
  await preload.fill('2,5');
  await context.setOffline(true);
  await preload.press('Enter');
  await page.waitForFunction(() => /^The server does not answer/.test(document.getElementById('judging-told').textContent));
  odd.length = 0;
  await context.setOffline(false);
  await preload.press('Enter');
  await page.waitForURL(/verdicts/, { timeout: 120_000 });
  await page.waitForSelector('#event .live');
  const first = page.url().split('/').at(-1);
  if (colorScheme === 'light') await sameByEveryDoor(page, first);

  // The card is the report's.
  const card = page.locator('#verdict');
  const report = await context.newPage();
  await report.goto(`${base}/v1/verdicts/${first}/report.html`);
  assert.equal(await card.innerText(), await report.locator('#verdict').innerText());
  await report.close();

  // Cursors by mouse and keys; a link keeps what is seen and read off.
  const plot = page.locator('#event > svg');
  const read = page.locator('#event output');
  const point = async () => {
    await plot.scrollIntoViewIfNeeded();
    const box = await plot.boundingBox();
    await page.mouse.move(box.x + box.width * 0.4, box.y + box.height * 0.5);
  };
  await point();
  assert.match(await read.innerText(), /^t .*φ .* rad/);
  await page.mouse.down();
  await page.mouse.up();
  await page.keyboard.press('Shift+ArrowRight');
  const apart = await read.innerText();
  assert.match(apart, /Δt .*Δφ/s);
  await page.keyboard.press('+');
  const drawn = await plot.locator('.drawn').textContent();
  const link = page.url();
  assert.match(link, /#t=[-0-9.]+&a=[-0-9.]+&b=[-0-9.]+$/);
  await look(page, `${colorScheme}-verdict`);
  await page.goto('about:blank');
  await page.goto(link);
  await page.waitForSelector('#event .live');
  assert.equal(await read.innerText(), apart);
  assert.equal(await plot.locator('.drawn').textContent(), drawn);

  // Downloads.
  const table = await downloaded(page, () => page.getByRole('link', { name: 'Download series' }).click());
  assert.match(String(table.bytes), /^time_s,.*\n/);
  const whole = await downloaded(page, () => page.getByRole('link', { name: 'Download report (HTML)' }).click());
  assert(whole.bytes.length > 100_000);

  // What if: the nominal lever until the varied levers have answered; by a number or the slider, which reaches
  // the advice. The answer is announced, its curve drawn beside the others.
  const preloaded = page.locator('[data-key="lever.preload_torque_nm"]');
  const [field, slider] = [preloaded.locator('input').first(), preloaded.locator('input[type=range]')];
  const told = page.locator('#what-if-told');
  assert.equal(await told.getAttribute('role'), 'status');
  assert(Number(await preloaded.getAttribute('data-high')) > 2.5);
  await field.fill('1,25');
  await page.waitForFunction(() => /^With preload torque 1,25 N·m: [A-Z]+\. The nominal lever/.test(document.getElementById('what-if-told').textContent));
  await page.waitForSelector('#event path.what-if');
  const curve = await plot.locator('path.what-if').getAttribute('d');
  await field.fill('a little');
  assert.equal(await field.getAttribute('aria-invalid'), 'true');
  await field.fill('1,25');
  await slider.focus();
  for (let step = 0; step < 5; step += 1) await page.keyboard.press('ArrowRight');
  await page.waitForFunction((before) => ![null, undefined, before].includes(document.querySelector('#event path.what-if')?.getAttribute('d')), curve);
  assert.match(await slider.getAttribute('aria-valuetext'), /^[\d.]+ N·m$/);
  await look(page, `${colorScheme}-what-if`);
  await page.locator('#what-if-back').click();
  await page.waitForFunction(() => document.querySelector('#event path.what-if') === null);
  await field.fill('1,25');
  await page.waitForFunction(() => /1,25/.test(document.getElementById('what-if-told').textContent));
  await page.locator('#what-if-judge').click();
  await page.waitForURL((url) => /verdicts/.test(url.pathname) && !url.pathname.includes(first), { timeout: 120_000 });
  await page.waitForSelector('#event .live');

  // Compare: what differs, and curves of both.
  await page.goto(base);
  await look(page, `${colorScheme}-home`);
  const boxes = page.locator('input[name=id][aria-label*="preload torque"]');
  await boxes.nth(0).check();
  await boxes.nth(1).check();
  await page.getByRole('button', { name: 'Compare the chosen ones' }).click();
  await page.waitForSelector('#event .live');
  // The list has the newest first, the comparison the oldest.
  assert.match(await page.locator('h1').innerText(), /^Preload torque 2\.5\sN·m → 1\.25\sN·m; all else equal: /);
  await page.locator('#differences summary').click();
  const keys = await page.locator('.differences code').allInnerTexts();
  assert(keys.includes('design.lever.preload_torque_nm') && !keys.includes('design.lever.mass_kg'), keys.join());
  await point();
  assert.match(await read.innerText(), /φ .* A · φ .* B/);
  await look(page, `${colorScheme}-compare`);
  const [before] = await page.locator('main').getByText(/^A · /).allInnerTexts();
  await page.getByRole('link', { name: 'put it first' }).click();
  await page.waitForSelector('#event .live');
  assert.notEqual((await page.locator('main').getByText(/^A · /).allInnerTexts())[0], before);

  // The margin over designs: a point leads to its run.
  await page.goto(base);
  await page.locator('table a[href^="/recordings/"]').first().click();
  await page.waitForSelector('svg.history');
  await look(page, `${colorScheme}-history`);
  await page.locator('svg.history a').first().focus();
  await page.keyboard.press('Enter');
  await page.waitForURL(/verdicts/);

  // Designs by version, with what differs.
  await page.goto(`${base}/designs`);
  const light = colorScheme === 'light';
  const name = page.locator('#design input[name=name]');
  await name.fill('Türschloss 7');
  await page.getByRole('button', { name: 'Keep' }).click();
  await marked(name, /^“ü” does not fit a name/);
  await name.fill('latch');
  await page.getByText('Change numbers of the lever').click();
  await page.locator('[name="lever.preload_torque_nm"]').fill(light ? '2,82' : '0,2');
  await page.getByRole('button', { name: 'Keep' }).click();
  await page.waitForFunction((text) => document.getElementById('designs')?.textContent.includes(text), light ? 'latch@1' : 'latch@2');
  assert.match(await page.locator('#designs').innerText(), /preload torque 2\.82\s+N·m \(was 0\.1\)/);
  await look(page, `${colorScheme}-designs`);

  // A gate, and one held against it: what changed comes first.
  await page.goto(`${base}/gates`);
  if (!light) await page.locator('select[name=baseline]').selectOption({ index: 1 });
  await look(page, `${colorScheme}-gates`);
  await page.locator('#gate-text').fill('require = "pass"\n[[recordings]]\nfiles = "*.csv"\n[[designs]]\nname = "balanced"\nset = { "lever.center_of_mass_m" = 0.0035 }\n[[designs]]\nname = "latch"\nfile = "latch"\n');
  await page.getByRole('button', { name: 'Judge' }).click();
  await page.waitForSelector('#matrix', { timeout: 120_000 });
  if (!light) assert.match(await page.locator('main').innerText(), /Changed since/);
  await look(page, `${colorScheme}-gate`);
  await page.locator('#matrix a', { hasText: 'PASS' }).first().click();
  await look(page, `${colorScheme}-pair`);
  if (page.url().includes('/runs/')) await page.locator('#pair').click();
  await page.waitForURL(/verdicts/, { timeout: 120_000 });
  assert.deepEqual(odd, [], 'requests elsewhere, or errors');
  await paper(page, `${base}/verdicts/${first}`);
  await phone(page, colorScheme, first);
  if (colorScheme === 'light') await deletion(page);
  await context.close();
}

// On paper a verdict has no links to pages, buttons or sliders, and its findings are unfolded.
async function paper(page, verdict) {
  await page.goto(verdict);
  await page.waitForSelector('#event .live');
  await page.emulateMedia({ media: 'print' });
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  assert.equal(await page.locator('nav:visible, button:visible, input:visible, .actions:visible').count(), 0);
  assert.equal(await page.locator('#findings:visible, #all-findings[open]:visible').count(), 1);
  assert.equal(await page.locator('main').getByText('Further findings').count(), 0);
  assert(await page.locator('.asked').isVisible());
  await page.emulateMedia({ media: 'screen' });
}

// On a phone no page is wider than the screen.
async function phone(page, colorScheme, verdict) {
  await page.setViewportSize({ width: 390, height: 844 });
  const links = async (address, start) => {
    await page.goto(`${base}${address}`);
    const found = await page.locator(`main a[href^="${start}"]`).first().getAttribute('href');
    return found;
  };
  const known = await page.request.get(`${base}/v1/verdicts`);
  const ids = (await known.json()).verdicts.slice(0, 3).map((one) => `id=${one.report_id}`);
  const pages = {
    home: '/', none: '/?filter=nowhere', recordings: '/recordings', recording: await links('/recordings', '/recordings/'),
    verdict: `/verdicts/${verdict}`, compare: `/compare?${ids.join('&')}`, choose: '/compare',
    gates: '/gates', gate: await links('/gates', '/gates/'), designs: '/designs', login: '/login',
  };
  for (const [name, address] of Object.entries(pages)) {
    await page.goto(`${base}${address}`);
    if (['verdict', 'compare'].includes(name)) await page.waitForSelector('#event .live');
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert(wide <= 390, `${name}: ${wide} wide on a phone`);
    await look(page, `${colorScheme}-phone-${name}`);
  }
  await page.goto(`${base}/?filter=nowhere`);
  await page.getByRole('link', { name: 'Clear the search' }).click();
  assert.equal(await page.locator('main').getByText('No verdict fits').count(), 0);
  await page.goto(`${base}/compare`);
  assert.match(await page.locator('main').innerText(), /Tick two to 8 verdicts/);
}

// A recording is deleted after a second word, and is gone from the list; lists are sorted by their heads.
async function deletion(page) {
  await page.setViewportSize({ width: 1200, height: 900 });
  await page.goto(`${base}/recordings`);
  const rows = page.locator('table.rows tbody tr');
  await page.getByRole('link', { name: 'File' }).click();
  await page.waitForURL(/sort=name/);
  const names = await rows.locator('a').allInnerTexts();
  assert.deepEqual(names, [...names].sort());
  assert.equal(await page.locator('th[aria-sort=ascending]').count(), 1);
  await page.locator('input[name=filter]').fill('many-light');
  await page.getByRole('button', { name: 'Show' }).click();
  await page.waitForURL(/filter=many-light/);
  assert.equal(await rows.count(), 1);
  assert.match(await rows.innerText(), /many-light\.csv.*local.*kB/s);
  await rows.locator('a').click();
  const button = page.getByRole('button', { name: 'Delete for good' });
  assert.equal(await button.isVisible(), false);
  await page.getByText('Delete this recording').click();
  await look(page, 'delete');
  await button.click();
  await page.waitForURL(/recordings$/);
  assert.equal(await page.getByText('many-light.csv').count(), 0);
}

// Who signs in is named on every page and may leave; a wrong token leaves the field there.
async function signing() {
  const closed = await started();
  const token = String(execFileSync(serviceProgram, ['token', 'create', 'lab', '--scopes', 'read,submit', '--data', closed.data])).match(/lg_[0-9a-f]+/)[0];
  const page = await browser.newPage();
  await page.goto(closed.address);
  await page.locator('input[name=token]').fill('lg_wrong');
  await page.getByRole('button', { name: 'Sign in' }).click();
  await marked(page.locator('input[name=token]'), /not known here/);
  await look(page, 'sign-in');
  await page.locator('input[name=token]').fill(token);
  await page.getByRole('button', { name: 'Sign in' }).click();
  await page.waitForSelector('#drop');
  assert.match(await page.locator('header.top').innerText(), /Signed in as lab/);
  assert.match(await page.locator('#drop').innerText(), /server named in the address bar.*sees every recording/);
  await page.getByRole('button', { name: 'Sign out' }).click();
  await page.waitForURL(/login/);
  assert.equal(await page.locator('input[name=token]').count(), 1);
  await page.close();
  await closed.stop();
}

// The header stays in its place from page to page, with a scrollbar and without.
async function steady() {
  const window = await launched({ ignoreDefaultArgs: ['--hide-scrollbars'] });
  const page = await window.newPage({ viewport: { width: 1400, height: 900 } });
  const { verdicts } = await (await page.request.get(`${base}/v1/verdicts`)).json();
  const [one, other] = verdicts;
  const [places, lengths] = [new Set(), new Set()];
  for (const address of ['/', `/verdicts/${one.report_id}`, `/recordings/${one.recording}`, `/compare?id=${one.report_id}&id=${other.report_id}`, '/recordings', '/gates', '/designs', '/compare', '/login', '/nowhere']) {
    await page.goto(`${base}${address}`);
    places.add(await page.evaluate(() => JSON.stringify(['.brand', '.top nav', 'main'].map((part) => { const { left, width } = document.querySelector(part).getBoundingClientRect(); return [left, width]; }))));
    lengths.add(await page.evaluate(() => document.documentElement.scrollHeight > innerHeight));
  }
  assert.equal(places.size, 1, [...places].join('\n'));
  assert.equal(lengths.size, 2, 'some pages scroll, some do not');
  await window.close();
}

let failed = false;
try {
  for (const scheme of ['light', 'dark']) {
    await sampled(scheme);
    await walk(scheme);
    process.stdout.write(`${scheme}: as it should be\n`);
  }
  await steady();
  await signing();
  process.stdout.write('signing in and out: as it should be\n');
} catch (error) {
  failed = true;
  process.stderr.write(`${error.stack}\n`);
}
await browser.close();
await service.stop();
process.exit(failed ? 1 : 0);
