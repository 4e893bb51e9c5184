// The report as it looks and as it is worked with: a picture of it in light and dark, its sheets of paper, keys and
// buttons of its plot, and the PDF that the program prints. Pages made for it show that the measures tell a good
// page from an empty one.
//
// Pictures are written to target/browser/.

import { strict as assert } from 'node:assert';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { latchgate, launched, openFile, pictures, signal } from './common.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'latchgate-report-'));
const browser = await launched();

// Measures a picture, as far as a program can tell what it shows:
// - colours: distinct ones, each channel coarsened to 16 steps
// - inked: share of pixels that differ from the most frequent colour
// - brightness: mean, 0 to 255
// - inkedBands of bands: horizontal bands of 100 pixels that hold ink
async function measured(page, png) {
  return page.evaluate(async (encoded) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${encoded}`)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const pixels = new Uint16Array(data.length / 4);
    const counts = new Map();
    let total = 0;
    for (let index = 0; index < pixels.length; index += 1) {
      const [red, green, blue] = [0, 1, 2].map((channel) => data[4 * index + channel] >> 4);
      pixels[index] = (red << 8) | (green << 4) | blue;
      counts.set(pixels[index], (counts.get(pixels[index]) ?? 0) + 1);
      total += 17 * (red + green + blue);
    }
    const [ground, groundCount] = [...counts].reduce((most, next) => (next[1] > most[1] ? next : most));
    const band = image.width * 100;
    let [inkedBands, bands] = [0, 0];
    for (let start = 0; start < pixels.length; start += band, bands += 1) {
      const ink = pixels.subarray(start, start + band).reduce((count, pixel) => count + (pixel !== ground), 0);
      if (ink > 50) inkedBands += 1;
    }
    return {
      colours: counts.size, inked: 1 - groundCount / pixels.length, brightness: total / (3 * pixels.length), inkedBands, bands,
    };
  }, png.toString('base64'));
}

// Takes a picture of a page, 1000 pixels wide and 3000 high, and measures it.
async function looks(file, colorScheme, name) {
  const context = await browser.newContext({ colorScheme, viewport: { width: 1000, height: 3000 } });
  const { page, odd } = await openFile(context, file);
  const png = await page.screenshot({ path: path.join(pictures, `${name}-${colorScheme}.png`) });
  assert.deepEqual(odd, [], `${name}, ${colorScheme}`);
  // A page of its own, so that no policy of the one that was shown is in the way.
  const scratch = await context.newPage();
  const measures = await measured(scratch, png);
  await context.close();
  return measures;
}

// Prints a page as its own rules of paper say; returns the sizes of its sheets [pt].
async function sheets(file) {
  const context = await browser.newContext();
  const { page } = await openFile(context, file);
  const printed = (await page.pdf({ preferCSSPageSize: true })).toString('latin1');
  await context.close();
  return [...printed.matchAll(/\/MediaBox\s*\[([^\]]*)\]/g)].map(([, box]) => {
    const [left, bottom, right, top] = box.trim().split(/\s+/).map(Number);
    return [right - left, top - bottom];
  });
}

function written(name, html) {
  const file = path.join(folder, name);
  writeFileSync(file, html);
  return file;
}

// The measures would be worth nothing if an empty page passed them.
const empty = await looks(written('empty.html', '<!doctype html><title>empty</title>'), 'light', 'empty');
assert.equal(empty.colours, 1, JSON.stringify(empty));
assert.equal(empty.inkedBands, 0, JSON.stringify(empty));
assert.equal(empty.bands, 30, JSON.stringify(empty));

// Colour scheme and size of paper are what the page asks for, and no constant of the browser.
const scheme = written('scheme.html', '<!doctype html><style>@page{size:A5} body{background:#fff} '
  + '@media (prefers-color-scheme: dark){body{background:#000}}</style>');
assert.ok((await looks(scheme, 'light', 'scheme')).brightness > 250, 'a white page');
assert.ok((await looks(scheme, 'dark', 'scheme')).brightness < 5, 'a black page');
const small = await sheets(scheme);
assert.equal(small.length, 1);
assert.ok(Math.abs(small[0][0] - 419.5) < 1, `A5: ${small}`);

// The report of a failing and of a passing recording can be seen in light and dark, and printed.
for (const [name, recording, code] of [['burst', 'burst.csv', 1], ['surviving', 'surviving.csv', 0]]) {
  latchgate(folder, code, 'replay', signal(recording), '--out', name);
  const file = path.join(folder, name, 'report.html');
  const html = readFileSync(file, 'utf8');
  for (const fetched of ['src="http', 'href="http', 'url(http', '@import']) {
    assert.ok(!html.includes(fetched), `${name}: the report must open offline, found ${fetched}`);
  }
  const [light, dark] = [await looks(file, 'light', `report-${name}`), await looks(file, 'dark', `report-${name}`)];
  for (const [view, seen] of Object.entries({ light, dark })) {
    const measures = `${name}, ${view}: ${JSON.stringify(seen)}`;
    assert.ok(seen.colours >= 12 && seen.inked > 0.02 && seen.inked < 0.8, `too plain for verdict, curves and a spectrogram: ${measures}`);
    assert.ok(seen.inkedBands * 10 >= seen.bands * 8, `large parts are empty: ${measures}`);
  }
  assert.ok(light.brightness > 180 && dark.brightness < 90, `${name}: ${JSON.stringify({ light, dark })}`);
  const sizes = await sheets(file);
  assert.ok(sizes.length >= 2 && sizes.length <= 12, `${name}: ${sizes.length} sheets`);
  for (const [width, height] of sizes) {
    // A4 is 210 mm x 297 mm.
    assert.ok(Math.abs(width - 595.28) < 1 && Math.abs(height - 841.89) < 1, `${name}: a sheet of ${width} x ${height} pt, expected A4`);
  }
}

// The script runs under the page's own policy; without it the page is what is written.
const report = path.join(folder, 'burst/report.html');
const source = readFileSync(report, 'utf8');
assert.ok(!source.includes('<button'), 'buttons that do nothing without a script');
const [drawn] = source.split('<script');
assert.ok(drawn.includes('id="event"') && drawn.includes('class="run-'), 'the plot is there without a script');
const context = await browser.newContext({ viewport: { width: 1200, height: 900 } });
const { page, odd } = await openFile(context, report);
for (const name of ['Whole record', 'Download series']) {
  assert.equal(await page.locator('#event').getByText(name, { exact: true }).count(), 1, name);
}

// Keys move cursors and zoom; a button takes a curve away.
const plot = page.locator('#event svg').first();
const readings = () => page.locator('#event output').textContent();
const shown = () => plot.locator('.drawn').textContent();
const curves = () => plot.locator('.drawn path').count();
const press = (key) => plot.press(key);
await press('ArrowRight');
assert.match(await readings(), /^t .*m\/s.*rad/s, 'a cursor reads off');
await press('b');
await press('Shift+ArrowRight');
assert.match(await readings(), /Δt .*Δa /s, 'a second cursor shows the difference');
const whole = await shown();
await press('+');
assert.notEqual(await shown(), whole, '+ zooms');
await press('0');
assert.equal(await shown(), whole, '0 shows the whole record');
const before = await curves();
await page.locator('#event .live button[aria-pressed]').first().click();
assert.equal(before - await curves(), 1, 'a button takes one curve away');
await press('Escape');
assert.match(await readings(), /^Point at the plot/, 'Escape takes the cursors away');
assert.deepEqual(odd, [], 'requests elsewhere, or errors');
await context.close();
await browser.close();

// The program prints the report itself, by the browser that it finds.
const printing = ['replay', signal('surviving.csv'), '--members', '0', '--pdf', '--out', 'printed'];
assert.equal(latchgate(folder, 0, ...printing), '');
const pdf = path.join(folder, 'printed/report.pdf');
const bytes = readFileSync(pdf);
assert.ok(bytes.subarray(0, 5).toString() === '%PDF-' && bytes.length > 20_000, `${bytes.length} bytes`);
// What could not be written before it is printed is still said.
assert.match(latchgate(folder, 4, ...printing, '--series', 'no-such-folder/series.csv'), /no-such-folder/);
// Another report in its place has no PDF until it is printed.
latchgate(folder, 0, 'replay', signal('surviving.csv'), '--members', '0', '--filter', 'none', '--out', 'printed');
assert.ok(!existsSync(pdf), 'the PDF of another report stays');

rmSync(folder, { recursive: true, force: true });
console.log('the report: looks, sheets, keys and PDF as they should be');
