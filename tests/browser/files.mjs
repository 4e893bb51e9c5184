// The pages that lie in files, as a browser shows them: report, margin, two verdicts compared, gate. On a desk
// in light and dark, and on a phone; checked for accessibility, without any request, complete without scripts.
//
// Pictures are written to target/browser/.

import { strict as assert } from 'node:assert';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { devices } from 'playwright-core';
import { barriers, latchgate as run, launched, openFile, pictures, root } from './common.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'latchgate-files-'));
const latchgate = (code, ...words) => run(folder, code, ...words);

const burst = path.join(root, 'signals/burst.csv');
latchgate(1, 'replay', burst, '--out', 'fail');
latchgate(1, 'replay', burst, '--set', 'lever.preload_torque_nm=2.82', '--out', 'other');
latchgate(0, 'replay', path.join(root, 'signals/surviving.csv'), '--out', 'pass');
writeFileSync(path.join(folder, 'clipped.csv'), readFileSync(path.join(root, 'signals/surviving.csv')));
writeFileSync(path.join(folder, 'clipped.csv.toml'), 'opens_when = "negative"\nrange_g = 2\n');
latchgate(4, 'replay', 'clipped.csv', '--out', 'unusable');
writeFileSync(path.join(folder, 'undeclared.csv'), readFileSync(path.join(root, 'signals/half_sine_30g_11ms.csv')));
latchgate(3, 'replay', 'undeclared.csv', '--out', 'undecided');
latchgate(0, 'margin', path.join(root, 'signals/half_sine_30g_11ms.csv'), '--members', '0', '--out', 'margin');
latchgate(1, 'compare', 'fail/verdict.json', 'other/verdict.json', '--out', 'compare');
latchgate(0, 'gate', path.join(root, 'docs/gate/gate.toml'), '--no-store', '--reports', 'none', '--out', 'gate');
const pages = {
  fail: 'fail/report.html', pass: 'pass/report.html', undecided: 'undecided/report.html', unusable: 'unusable/report.html',
  margin: 'margin/margin.html', compare: 'compare/compare.html', gate: 'gate/index.html',
};

const browser = await launched();
const open = (context, file) => openFile(context, path.join(folder, file));

const views = {
  light: { colorScheme: 'light', viewport: { width: 1200, height: 900 } },
  dark: { colorScheme: 'dark', viewport: { width: 1200, height: 900 } },
  phone: { ...devices['Pixel 7'], colorScheme: 'light' },
};
for (const [view, options] of Object.entries(views)) {
  const context = await browser.newContext(options);
  for (const [name, file] of Object.entries(pages)) {
    const { page, odd } = await open(context, file);
    assert.deepEqual(await barriers(page), [], `${view}, ${name}: accessibility`);
    const [wide, shown] = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    assert.ok(wide <= shown, `${view}, ${name}: the page is ${wide} wide, the window ${shown}`);
    const spilt = await page.evaluate(() => [...document.querySelectorAll('table')]
      .filter((table) => table.getBoundingClientRect().width > table.parentElement.clientWidth + 1)
      .map((table) => table.caption?.textContent ?? table.textContent.slice(0, 80)));
    if (view !== 'phone') assert.deepEqual(spilt, [], `${view}, ${name}: tables wider than their card`);
    await page.screenshot({ path: path.join(pictures, `${view}-${name}.png`), fullPage: true });
    assert.deepEqual(odd, [], `${view}, ${name}`);
    await page.close();
  }
  await context.close();
}

// By touch: a tap reads off, with a second cursor the difference is shown, two fingers zoom.
const phone = await browser.newContext(views.phone);
for (const name of ['fail', 'compare']) {
  const { page, odd } = await open(phone, pages[name]);
  const svg = page.locator('#event > svg');
  const place = async (part) => {
    await svg.evaluate((one) => one.scrollIntoView({ block: 'center' }));
    const box = await svg.boundingBox();
    return { x: box.x + box.width * part, y: box.y + box.height * 0.5 };
  };
  const tap = async (part) => {
    const at = await place(part);
    await page.touchscreen.tap(at.x, at.y);
  };
  const said = () => page.locator('#event output').textContent();
  await tap(0.4);
  assert.match(await said(), /rad/, `${name}: a tap reads off`);
  await page.getByRole('button', { name: 'Second cursor' }).click();
  await tap(0.5);
  assert.match(await said(), /Δt .*Δφ/s, `${name}: a second cursor shows the difference`);
  const before = await page.locator('#event .drawn').textContent();
  const pinch = await phone.newCDPSession(page);
  for (const [type, apart] of [['touchStart', 0.1], ['touchMove', 0.3], ['touchMove', 0.5]]) {
    const touchPoints = [{ ...await place(0.5 - apart / 2), id: 0 }, { ...await place(0.5 + apart / 2), id: 1 }];
    await pinch.send('Input.dispatchTouchEvent', { type, touchPoints });
  }
  await pinch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  assert.notEqual(await page.locator('#event .drawn').textContent(), before, `${name}: two fingers zoom`);
  assert.deepEqual(odd, [], name);
  await page.close();
}
await phone.close();

// Without scripts the page holds everything that decides.
const plain = await browser.newContext({ javaScriptEnabled: false });
for (const [name, file] of Object.entries(pages)) {
  const { page } = await open(plain, file);
  assert.ok((await page.locator('main').innerText()).length > 300, `${name}: without scripts`);
  assert.equal(await page.locator('button:visible').count(), 0, `${name}: buttons that do nothing`);
  await page.close();
}
await plain.close();

// What decides is short. On paper page one holds verdict, plot and what was judged, page two all that the signature
// at its end stands for; how sure it is may take a third.
const desk = await browser.newContext(views.light);
for (const name of ['fail', 'pass', 'undecided', 'unusable']) {
  const { page } = await open(desk, pages[name]);
  const words = await page.evaluate(() => {
    const main = document.querySelector('main').cloneNode(true);
    main.querySelectorAll('svg, details, .second, #appendix, script, .live').forEach((one) => one.remove());
    return main.textContent.trim().split(/\s+/).length;
  });
  assert.ok(words <= 300, `${name}: ${words} words on page one`);
  // On a sheet of A4 within its margins, in points of the screen.
  const sheet = { width: 680, height: 1017 };
  await page.emulateMedia({ media: 'print' });
  await page.setViewportSize(sheet);
  const [before, judged] = await page.evaluate(() => {
    const top = document.querySelector('main').getBoundingClientRect().top;
    const box = document.querySelector('#judged').getBoundingClientRect();
    return [box.top - top, box.height];
  });
  assert.ok(before <= sheet.height, `${name}: page one takes ${before} of ${sheet.height}`);
  assert.ok(judged <= sheet.height, `${name}: page two takes ${judged} of ${sheet.height}`);
  const printed = (await page.pdf({ preferCSSPageSize: true })).toString('latin1');
  const sheets = printed.match(/\/Type\s*\/Page\b/g).length;
  assert.ok(sheets <= 3, `${name}: ${sheets} sheets`);
  console.log(`${name}: ${words} words on page one, ${sheets} sheets`);
  await page.close();
}
await browser.close();
rmSync(folder, { recursive: true, force: true });
console.log('pages in files: all as they should be');
