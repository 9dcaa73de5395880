// Measures the time until a large build is visible: node large.mjs '{"chromium": ..., "base": ..., "build": ..., "copies": ...}'.
import assert from "node:assert/strict";
import { drawn, open, pixels, start } from "./browser.mjs";

const farm = JSON.parse(process.argv[2]);
const browser = await start(farm.chromium);
const told = [];
for (const what of ["first time", "again"]) {
  const began = performance.now();
  const page = await open(browser, farm.base, `/builds/${farm.build}`);
  assert.equal(await drawn(page), farm.copies);
  told.push({ what, secs: (performance.now() - began) / 1000, bytes: page.bytes });
  assert.ok((await pixels(page)).colours > 100);
  assert.deepEqual(page.wrong, []);
  await page.context().close();
}
await browser.close();
console.log(JSON.stringify(told));
