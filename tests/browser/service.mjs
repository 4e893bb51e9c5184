// The page of the service as a browser shows it: upload, channel, verdict, cursors, what-if, compare,
// permalink, download; in light and dark, checked for accessibility, without any request elsewhere.
//
//     tests/browser/run      needs Node.js, Chromium, and latchgate-serve as built
//
// Pictures are written to target/browser/.

import { spawn } from 'node:child_process';
import { strict as assert } from 'node:assert';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { chromium } from 'playwright-core';

const root = process.env.LATCHGATE_ROOT;
const program = process.env.LATCHGATE_SERVE || path.join(root, 'target/debug/latchgate-serve');
const browserPath = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((file) => file && existsSync(file));
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const pictures = path.join(root, 'target/browser');
mkdirSync(pictures, { recursive: true });
const data = mkdtempSync(path.join(tmpdir(), 'latchgate-browser-'));

const service = spawn(program, ['--listen', '127.0.0.1:0', '--data', data, '--set', 'log=warn'], { stdio: ['ignore', 'pipe', 'inherit'] });
const base = await new Promise((resolve, reject) => {
  service.stdout.once('data', (text) => resolve(String(text).match(/http:\/\/[^/]+/)[0]));
  service.once('exit', () => reject(new Error('the service did not start')));
});
const browser = await chromium.launch({ executablePath: browserPath, args: ['--no-sandbox', '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1'] });

async function look(page, name) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
  const told = violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.html).slice(0, 3).join(' | ')}`);
  assert.deepEqual(told, [], `${name}: accessibility`);
  await page.screenshot({ path: path.join(pictures, `${name}.png`), fullPage: true });
}

async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
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

  // Verdict, by the keyboard alone.
  await page.locator('input[name=set]').fill('lever.preload_torque_nm=2.5');
  await page.locator('input[name=set]').press('Enter');
  await page.waitForURL(/verdicts/, { timeout: 120_000 });
  await page.waitForSelector('#plots[data-ready=yes]');
  const first = page.url().split('/').at(-1);

  // Cursors, moved by keys.
  const motion = page.locator('#motion');
  const box = await page.locator('#plot-angle .u-over').boundingBox();
  await page.mouse.move(box.x + box.width * 0.3, box.y + 40);
  await motion.focus();
  await page.keyboard.press('a');
  await page.mouse.move(box.x + box.width * 0.5, box.y + 40);
  await page.keyboard.press('b');
  await page.waitForFunction(() => /Δt/.test(document.getElementById('d-time').textContent));
  const apart = await page.locator('#d-time').textContent();
  await page.keyboard.press('Shift+ArrowRight');
  await page.waitForFunction((was) => document.getElementById('d-time').textContent !== was, apart);
  assert.match(await page.locator('#d-angle').textContent(), /Δφ/);

  // A permalink keeps range, cursors and channels.
  await page.keyboard.press('+');
  await page.waitForFunction(() => new URLSearchParams(location.search).has('t0'));
  await page.locator('#columns input').first().uncheck();
  await page.waitForFunction(() => new URLSearchParams(location.search).has('hide'));
  const link = page.url();
  const times = await page.locator('#cursors').innerText();
  await page.goto('about:blank');
  await page.goto(link);
  await page.waitForSelector('#plots[data-ready=yes]');
  assert.equal(page.url(), link);
  assert.equal(await page.locator('#cursors').innerText(), times);
  assert.equal(await page.locator('#columns input').first().isChecked(), false);
  await look(page, `${colorScheme}-verdict`);

  // Downloads of what is visible, and of the whole.
  const query = new URLSearchParams(new URL(link).search);
  const table = await downloaded(page, () => page.locator('[data-do=csv]').click());
  assert.match(table.name, /^burst\.csv-.*\.csv$/);
  const rows = String(table.bytes).trim().split('\n').slice(1).map((line) => Number(line.split(',')[0]));
  assert(rows.length > 10 && rows[0] >= Number(query.get('t0')) && rows.at(-1) <= Number(query.get('t1')));
  const svg = await downloaded(page, () => page.locator('[data-do=svg]').click());
  assert.match(String(svg.bytes), /^<svg .*polyline/s);
  const png = await downloaded(page, () => page.locator('[data-do=png]').click());
  assert.equal(png.bytes.subarray(1, 4).toString(), 'PNG');
  const report = await downloaded(page, () => page.getByRole('link', { name: 'download it (HTML)' }).click());
  assert(report.bytes.length > 100_000);

  // What if: nominal until the ensemble has answered.
  const slider = page.locator('[data-key="lever.preload_torque_nm"]');
  await slider.focus();
  for (let step = 0; step < 5; step += 1) await page.keyboard.press('ArrowRight');
  await page.waitForFunction(() => /^Nominal/.test(document.getElementById('what-if-told').textContent));
  await page.locator('#what-if-judge').click();
  await page.waitForURL((url) => /verdicts/.test(url.pathname) && !url.pathname.includes(first), { timeout: 120_000 });
  await page.waitForSelector('#plots[data-ready=yes]');

  // Compare: what differs, and nothing else.
  await page.goto(base);
  await look(page, `${colorScheme}-home`);
  const boxes = page.locator('input[name=id]');
  await boxes.nth(0).check();
  await boxes.nth(1).check();
  await page.getByRole('button', { name: 'Compare the chosen ones' }).click();
  await page.waitForSelector('#compare[data-ready=yes]');
  const visible = await page.locator('#differences tbody tr:visible th').allInnerTexts();
  assert(visible.includes('design.lever.preload_torque_nm') && !visible.includes('design.lever.mass_kg'), visible.join());
  await look(page, `${colorScheme}-compare`);
  await page.locator('#show-all').check();
  assert(await page.locator('#differences tr.same').first().isVisible());
  await page.reload();
  assert(await page.locator('#show-all').isChecked(), 'the switch stays as it was set');
  assert.deepEqual(odd, [], 'requests elsewhere, or errors');
  await context.close();
}

let failed = false;
try {
  for (const scheme of ['light', 'dark']) {
    await walk(scheme);
    process.stdout.write(`${scheme}: as it should be\n`);
  }
} catch (error) {
  failed = true;
  process.stderr.write(`${error.stack}\n`);
}
await browser.close();
service.kill('SIGTERM');
await new Promise((resolve) => service.once('exit', resolve));
rmSync(data, { recursive: true, force: true });
process.exit(failed ? 1 : 0);
