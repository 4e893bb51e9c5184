// What every test of the pages needs: where things lie, the programs, and a browser.
//
// tests/browser/run names programs and browser in the environment; nothing is looked for here.

import { spawnSync } from 'node:child_process';
import { strict as assert } from 'node:assert';
import { mkdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { chromium } from 'playwright-core';

export const root = process.env.LATCHGATE_ROOT;
export const latchgateProgram = process.env.LATCHGATE;
export const serviceProgram = process.env.LATCHGATE_SERVE;
export const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

// Pictures of every page, for whoever wants to look.
export const pictures = path.join(root, 'target/browser');
mkdirSync(pictures, { recursive: true });

// Returns the path of a recording of the project.
export const signal = (name) => path.join(root, 'signals', name);

// Runs latchgate in a folder; it must end with this code. Returns its standard error.
export function latchgate(folder, code, ...words) {
  const done = spawnSync(latchgateProgram, words, { cwd: folder, encoding: 'utf8' });
  assert.equal(done.status, code, `${words.join(' ')}\n${done.stdout}${done.stderr}`);
  return done.stderr;
}

// Starts the browser; it reaches no other host.
export function launched(options = {}) {
  return chromium.launch({
    ...options,
    executablePath: process.env.CHROMIUM,
    args: ['--no-sandbox', '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1'],
  });
}

// Opens a page that lies in a file; `odd` collects requests elsewhere and errors.
export async function openFile(context, file) {
  const page = await context.newPage();
  const odd = [];
  page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) odd.push(request.url()); });
  page.on('console', (message) => { if (message.type() === 'error') odd.push(message.text()); });
  page.on('pageerror', (error) => odd.push(String(error)));
  await page.goto(`file://${file}`);
  return { page, odd };
}

// Lists what axe objects to on a page.
export async function barriers(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
  return violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.html).slice(0, 3).join(' | ')}`);
}
