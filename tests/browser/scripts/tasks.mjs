// Eight tasks of people, by clicks, keys and seconds: node tasks.mjs '{"chromium": ..., "base": ..., ...}'; tests/browser/tasks.rs calls it.
// A word that is typed counts as one entry. Seconds are those of pages and farm, without the time that a person thinks.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { drawn, open, start } from "./browser.mjs";
import { shoot } from "./shots.mjs";

const farm = JSON.parse(process.argv[2]), { base } = farm;
const browser = await start(farm.chromium);

/** A page that counts what a person does. */
class Person {
  constructor(page) { this.page = page; this.clicks = 0; this.entries = 0; }
  async click(target) { this.clicks += 1; await target.click(); }
  async enter(target, text) { this.entries += 1; await target.fill(text); }
  async search(text) { this.entries += 1; await this.page.keyboard.press("/"); await this.page.keyboard.type(text); await this.page.keyboard.press("Enter"); await this.page.getByRole("heading", { level: 1, name: /^Search/ }).waitFor(); }
  text() { return this.page.innerText("main"); }
  link(name, options = {}) { return this.page.getByRole("link", { name, ...options }).first(); }
}

// Each begins on the farm page: what it is, the most clicks and entries that it may take, and what is done.
const tasks = [
  ["whose part is this", 3, async (one) => {
    await one.search(`build ${farm.build}`);
    await one.click(one.link(`Build ${farm.build}`, { exact: true }));
    await drawn(one.page);
    const box = await one.page.locator("#view canvas").boundingBox(), said = one.page.locator("#hover");
    for (let row = 8; row > 2; row -= 1) for (let column = 3; column < 8; column += 1) {
      await one.page.mouse.move(box.x + box.width * column / 10, box.y + box.height * row / 10);
      await one.page.waitForTimeout(60);
      if (/, order .+, copy \d+/.test(await said.innerText())) { one.clicks += 1; await one.page.mouse.down(); await one.page.mouse.up(); return said.innerText(); }
    }
    assert.fail("no copy is under the pointer");
  }],
  ["what is late", 0, async (one) => {
    const late = one.page.getByRole("region", { name: "Late, or at risk to be" }).getByRole("link", { name: /late_part\.stl/ });
    assert.match(await late.innerText(), /late[^]*due 15 Jan/);
    return late.innerText();
  }],
  ["what failed, and print it again", 3, async (one) => {
    const failed = one.page.locator(".failed");
    assert.match(await failed.innerText(), /bed moved/);
    await one.click(failed.getByRole("link").first());
    await one.click(one.page.getByRole("button", { name: "Issue once more" }));
    await one.click(one.page.getByRole("button", { name: /^Issue this build once more/ }));
    const answer = await one.page.locator("#answer").innerText();
    assert.match(answer, /is issued once more as build/);
    return answer;
  }],
  ["break out order 1182", 4, async (one) => {
    await one.search("1182");
    await one.click(one.link("1182", { exact: true }));
    await one.click(one.page.getByRole("region", { name: "Builds" }).getByRole("link").first());
    await one.click(one.link("Break it out step by step"));
    await one.page.getByRole("heading", { level: 1 }).waitFor();
    assert.match(one.page.url(), /break-out/);
    return one.page.getByRole("heading", { level: 1 }).innerText();
  }],
  ["add 12 hinges by Friday", 6, async (one) => {
    const card = one.page.locator(`section[aria-label="${farm.machine}"]`);
    await one.click(card.locator("summary", { hasText: "Add files" }));
    await one.enter(card.locator("input[name=copies]"), "12");
    await one.enter(card.locator("input[name=due]"), farm.friday);
    one.clicks += 1; // the dialog of the browser that chooses the file
    await card.locator("input[type=file]").setInputFiles({ name: "hinge.stl", mimeType: "model/stl", buffer: readFileSync(farm.sample) });
    await one.click(card.getByRole("button", { name: /^Add to/ }));
    const said = card.getByText("hinge.stl is in the hot folder");
    await said.waitFor({ timeout: 30000 });
    return said.innerText();
  }],
  ["why was this refused", 0, async (one) => {
    const line = one.page.locator(".needs .part-line", { hasText: "torn.stl" });
    assert.match(await line.innerText(), /truncated/);
    return line.locator("p").innerText();
  }],
  ["which machine is free tonight", 0, async (one) => {
    const free = one.page.locator(".machine h2", { has: one.page.locator(".chip", { hasText: /^free$/ }) });
    assert.ok(await free.count() >= 1);
    return (await free.allInnerTexts()).join(", ");
  }],
  ["how many litres in this month and the one before", 1, async (one) => {
    await one.click(one.link("Month"));
    const cell = one.page.getByRole("region", { name: "Machines" }).locator("tbody tr").last().locator("td").nth(6);
    assert.ok(Number.parseFloat(await cell.innerText()) > 0, await cell.innerText());
    return `${(await cell.innerText()).replace("\n", " l; the month before ")}`;
  }],
];

if (farm.shots) {
  const build = `/builds/${farm.build}`, shots = [["farm", "/"], ["build", build], ["pick", `${build}/pick`], ["history", "/history"], ["month", "/month"], ["order", "/orders/1182"],
    ["search", "/search?q=e"], ["parts", "/parts?state=built"], ["part", "/parts/1"], ["drop", `/machines/${farm.machine}/drop`]].map(([name, path]) => [name, path, 1280, "light"]);
  for (const [name, path] of [["farm", "/"], ["build", build]]) shots.push([name, path, 390, "dark"]);
  await shoot(browser, base, [...shots, ["build", build, 1280, "dark"], ["flush", `/machines/${farm.machine}/flush`, 390, "light"]], farm.shots);
}
let failed = 0;
for (const [name, most, act] of tasks) {
  const page = await open(browser, base, "/", { width: 1440 }), one = new Person(page), began = performance.now();
  try {
    const found = await act(one), secs = (performance.now() - began) / 1000;
    assert.ok(one.clicks + one.entries <= most, `${one.clicks} clicks and ${one.entries} entries, ${most} at most`);
    console.log(`ok: ${name}: ${one.clicks} clicks, ${one.entries} entries, ${secs.toFixed(1)} s (${found.replaceAll("\n", " ").slice(0, 120)})`);
  } catch (error) {
    failed += 1;
    console.log(`FAILED: ${name}: ${error.message}`);
  }
  await page.context().close();
}

// Slow lines, kbit/s: a picture soon, and then the view.
for (const rate of [1600, 400]) {
  const page = await browser.newContext({ viewport: { width: 1280, height: 900 } }).then((context) => context.newPage());
  const session = await page.context().newCDPSession(page);
  await session.send("Network.enable");
  await session.send("Network.emulateNetworkConditions", { offline: false, latency: 50, downloadThroughput: rate * 125, uploadThroughput: rate * 125 });
  const began = performance.now(), since = () => (performance.now() - began) / 1000;
  await page.goto(`${base}/builds/${farm.build}`, { waitUntil: "commit" });
  await page.waitForFunction(() => { const image = document.querySelector(".poster img"); return image?.complete && image.naturalWidth > 100; }, null, { timeout: 60000 });
  const picture = since();
  await page.waitForFunction(() => document.querySelector("#view")?.dataset.drawn, null, { timeout: 120000 });
  const view = since(), slow = picture > 3 || view > 20;
  console.log(`${slow ? "FAILED" : "ok"}: at ${rate} kbit/s a picture after ${picture.toFixed(1)} s, the 3D view after ${view.toFixed(1)} s`);
  failed += slow ? 1 : 0;
  await page.context().close();
}
{
  const page = await browser.newContext({ viewport: { width: 390, height: 844 } }).then((context) => context.newPage());
  const session = await page.context().newCDPSession(page);
  await session.send("Network.enable");
  await session.send("Network.emulateNetworkConditions", { offline: false, latency: 50, downloadThroughput: 400 * 125, uploadThroughput: 400 * 125 });
  await page.goto(base, { waitUntil: "commit" });
  const painted = await page.waitForFunction(() => document.querySelector(".board") && performance.getEntriesByName("first-contentful-paint")[0]?.startTime, null, { timeout: 60000 });
  const secs = await painted.jsonValue() / 1000;
  console.log(`${secs > 2 ? "FAILED" : "ok"}: at 400 kbit/s the board after ${secs.toFixed(1)} s`);
  failed += secs > 2 ? 1 : 0;
  await page.context().close();
}
await browser.close();
process.exit(failed ? 1 : 0);
