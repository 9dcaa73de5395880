// Tasks of people, by mouse, touch and keyboard, in clicks, entries and seconds: node tasks.mjs '{"chromium": ..., "base": ..., ...}'; tests/browser/tasks.rs calls it.
// A word that is typed counts as one entry. Seconds are those of pages and farm, without the time that a person thinks.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { drawn, open, start } from "./browser.mjs";
import { shoot } from "./shots.mjs";

const farm = JSON.parse(process.argv[2]), { base } = farm;
const browser = await start(farm.chromium);

// The mouse comes last: what it drops on the soonest machine takes the free one.
const MODES = { touch: { viewport: { width: 820, height: 1180 }, hasTouch: true, isMobile: true }, keyboard: { width: 1440 }, mouse: { width: 1440 } };
/** Most presses of the tab key until something is reached. */
const MOST_TABS = 300;

/** A page that counts what a person does, by one of the modes. */
class Person {
  constructor(page, mode) { this.page = page; this.mode = mode; this.clicks = 0; this.entries = 0; }
  async click(target) {
    this.clicks += 1;
    if (this.mode === "keyboard") { await this.reach(target); await this.page.keyboard.press("Enter"); } else if (this.mode === "touch") await target.tap(); else await target.click();
  }
  /** Goes there by the tab key alone. */
  async reach(target) {
    // Asked anew each time: a page that changes by itself may have drawn it again.
    for (let tabs = 0; tabs < MOST_TABS; tabs += 1) {
      if (await target.evaluate((one) => document.activeElement === one)) return;
      await this.page.keyboard.press("Tab");
    }
    assert.fail(`the tab key does not reach ${await target.innerText()}`);
  }
  async enter(target, text) {
    this.entries += 1;
    if (this.mode === "keyboard") await this.reach(target);
    await target.fill(text);
  }
  async search(text) {
    this.entries += 1;
    if (this.mode === "touch") await this.page.locator("nav input[type=search]").tap(); else await this.page.keyboard.press("/");
    await this.page.keyboard.type(text);
    await this.page.keyboard.press("Enter");
    await this.page.getByRole("heading", { level: 1, name: /^Search/ }).waitFor();
  }
  text() { return this.page.innerText("main"); }
  link(name, options = {}) { return this.page.getByRole("link", { name, ...options }).first(); }
}

// Each begins on the farm page: what it is, the most clicks and entries that it may take, and what is done.
const tasks = [
  ["whose part is this", 3, async (one) => {
    await one.search(`build ${farm.build}`);
    await one.click(one.link(`Build ${farm.build}`, { exact: true }));
    await drawn(one.page);
    if (one.mode === "keyboard") {
      await one.click(one.page.locator(".view-part").first());
      return one.page.locator("#hover").innerText();
    }
    const box = await one.page.locator("#view canvas").boundingBox(), said = one.page.locator("#hover");
    for (let row = 8; row > 2; row -= 1) for (let column = 3; column < 8; column += 1) {
      const at = [box.x + box.width * column / 10, box.y + box.height * row / 10];
      if (one.mode === "touch") await one.page.touchscreen.tap(...at); else await one.page.mouse.move(...at);
      await one.page.waitForTimeout(60);
      if (!(one.mode === "touch" ? /^Chosen|copy \d+/ : /, order .+, copy \d+/).test(await said.innerText())) continue;
      one.clicks += 1;
      if (one.mode === "mouse") { await one.page.mouse.down(); await one.page.mouse.up(); }
      return said.innerText();
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
    await one.click(one.page.getByRole("button", { name: "The same build once more" }));
    const issue = one.page.getByRole("button", { name: /^Issue this build once more/ });
    // It is issued once: the last one presses the button.
    if (one.mode !== "mouse") { one.clicks += 1; assert.ok(await issue.isVisible()); return "asks for the last press"; }
    await one.click(issue);
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
  ["which machine is free tonight", 0, async (one) => {
    const free = one.page.locator(".machine h2", { has: one.page.locator(".chip", { hasText: /^free$/ }) });
    assert.ok(await free.count() >= 1);
    return (await free.allInnerTexts()).join(", ");
  }],
  ["12 hinges by Friday, on which machine", 6, async (one) => {
    const card = one.page.locator(`section[aria-label="${farm.machine}"]`), name = `hinge-by-${one.mode}.stl`, bytes = readFileSync(farm.sample);
    one.clicks += 1; // the drag, or the dialog of the browser that chooses the file
    let which = "its machine is known", form = card;
    if (one.mode === "mouse") {
      const files = await one.page.evaluateHandle(([name, text]) => { const all = new DataTransfer(); all.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name)); return all; }, [name, bytes.toString("base64")]);
      for (const kind of ["dragover", "drop"]) await card.dispatchEvent(kind, { dataTransfer: files });
      const soonest = one.page.getByRole("dialog").locator("li", { has: one.page.locator(".chip", { hasText: "soonest" }) }).getByRole("button");
      await soonest.waitFor({ timeout: 60000 });
      which = await soonest.innerText();
      await one.click(soonest);
      form = one.page.locator("section.machine", { has: one.page.locator("form.drop:focus-within") });
      form = one.page.locator(`section[aria-label="${await form.getAttribute("aria-label")}"]`);
    } else {
      await one.click(card.locator("summary", { hasText: "Add files" }));
      await card.locator("input[type=file]").setInputFiles({ name, mimeType: "model/stl", buffer: bytes });
    }
    await one.enter(form.locator("input[name=copies]"), "12");
    await one.enter(form.locator("input[name=due]"), farm.friday);
    await one.click(form.getByRole("button", { name: /^Add to/ }));
    const said = form.getByText(`${name} is in the hot folder`);
    await said.waitFor({ timeout: 30000 });
    return `${which}; ${await said.innerText()}`;
  }],
  ["why was this refused", 0, async (one) => {
    const line = one.page.locator(".needs .part-line", { hasText: "torn.stl" });
    assert.match(await line.innerText(), /truncated/);
    return line.locator("p").innerText();
  }],
  ["how many litres in this month and the one before", 1, async (one) => {
    await one.click(one.link("Month"));
    const cell = one.page.getByRole("region", { name: "Machines" }).locator("tbody tr").last().locator("td").nth(6);
    assert.ok(Number.parseFloat(await cell.innerText()) > 0, await cell.innerText());
    return `${(await cell.innerText()).replace("\n", " l; the month before ")}`;
  }],
  ["what do I tell the customer", 3, async (one) => {
    await one.search("1182");
    await one.click(one.link("1182", { exact: true }));
    await one.click(one.page.getByRole("button", { name: "Copy" }));
    return one.page.locator("#customer-note").innerText();
  }],
  ["get me the build file", 4, async (one) => {
    await one.search(`build ${farm.build}`);
    await one.click(one.link(`Build ${farm.build}`, { exact: true }));
    await one.click(one.page.getByRole("button", { name: "Files" }));
    const file = one.page.locator(":popover-open").getByRole("link", { name: /^Build file, 3MF/ });
    const [sent] = await Promise.all([one.page.waitForEvent("download"), one.click(file)]);
    assert.match(sent.suggestedFilename(), /\.build\.3mf$/);
    return sent.suggestedFilename();
  }],
  ["a bin label", 4, async (one) => {
    await one.search(`build ${farm.build}`);
    await one.click(one.link(`Build ${farm.build}`, { exact: true }));
    await one.click(one.page.getByRole("button", { name: "Labels for bins and bags" }));
    // Chromium shows no PDF as a phone: what the farm sends is looked at here.
    let sent = null;
    await one.page.route("**/labels.pdf*", async (route) => {
      const answer = await route.fetch();
      sent = { type: answer.headers()["content-type"], begins: (await answer.body()).toString("latin1", 0, 5) };
      await route.fulfill({ contentType: "text/plain", body: "seen" });
    });
    await one.click(one.page.getByRole("button", { name: "Open the PDF" }));
    await one.page.getByText("seen").waitFor();
    assert.deepEqual(sent, { type: "application/pdf", begins: "%PDF-" });
    return sent.type;
  }],
];

if (farm.shots) {
  const build = `/builds/${farm.build}`, shots = [["farm", "/"], ["build", build], ["pick", `${build}/pick`], ["history", "/history"], ["month", "/month"], ["order", "/orders/1182"],
    ["search", "/search?q=e"], ["parts", "/parts?state=built"], ["part", "/parts/1"], ["drop", `/machines/${farm.machine}/drop`]].map(([name, path]) => [name, path, 1280, "light"]);
  for (const [name, path] of [["farm", "/"], ["build", build]]) shots.push([name, path, 390, "dark"]);
  await shoot(browser, base, [...shots, ["build", build, 1280, "dark"], ["flush", `/machines/${farm.machine}/flush`, 390, "light"]], farm.shots);
}
let failed = 0;
for (const [mode, options] of Object.entries(MODES)) for (const [what, most, act] of tasks) {
  const page = await open(browser, base, "/", options), one = new Person(page, mode), name = `${what}, by ${mode}`, began = performance.now();
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

// The first screen of a phone shows what needs a person, what is late and the first machine, with 3 things and a late order open.
for (const locale of ["en", "de", "fr", "ja"]) {
  const page = await open(browser, base, "/", { locale, viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await page.locator("section.machine h2").first().waitFor();
  // At one moment: the page changes by itself.
  const [needs, late, machine] = await page.evaluate(() => {
    const bottom = (selector) => Math.round(document.querySelector(selector).getBoundingClientRect().bottom);
    const needs = [...document.querySelectorAll(".need-line")].filter((line) => line.checkVisibility()).length;
    return [needs, bottom(".risks .row"), bottom("section.machine h2")];
  });
  const is = needs >= 3 && late < machine && machine < 844;
  console.log(`${is ? "ok" : "FAILED"}: the first screen of a phone in ${locale}: ${needs} things in a line each, late until ${late}, the name of the first machine until ${machine} of 844 px`);
  failed += is ? 0 : 1;
  const line = page.locator(".need-line").first(), name = await line.innerText();
  await line.tap();
  const opened = page.locator(".need-body:popover-open");
  if (!await opened.isVisible() || !name.trim()) { console.log(`FAILED: a press on "${name}" opens it in ${locale}`); failed += 1; }
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
  const view = since(), slow = picture > 3.5 || view > 20;
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
