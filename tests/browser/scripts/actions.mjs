// Checks of what the pages do: to search, add files, follow what changes, and give orders.
import assert from "node:assert/strict";
import { copyFileSync, readFileSync, renameSync } from "node:fs";
import { join } from "node:path";
import { drawn, open, pixels, violations } from "./browser.mjs";
import { PAGES, api, base, browser, builds, clean, farm, until } from "./setting.mjs";

export const checks = {
  async "the search is on every page, the key / leads to it, and it finds what it should"() {
    const page = await open(browser, base, PAGES.history);
    await page.keyboard.press("/");
    await page.keyboard.type("MÜLLER");
    await page.keyboard.press("Enter");
    await page.getByRole("heading", { name: "Search: MÜLLER" }).waitFor();
    assert.equal(await page.getByRole("region", { name: "orders" }).getByRole("link").first().innerText(), "Müller & Söhne");
    await page.fill("nav input[type=search]", `build ${farm.build}`);
    await page.keyboard.press("Enter");
    await page.getByRole("link", { name: `Build ${farm.build}`, exact: true }).click();
    await page.getByRole("heading", { level: 1, name: `Build ${farm.build} on` }).waitFor();
    assert.deepEqual(page.wrong.filter((wrong) => !/live/.test(wrong)), []);
    await page.context().close();
  },

  async "files are added by form and by dropping them, with and without JavaScript"() {
    const waits = async (name) => (await api(`/api/v1/parts?name=${encodeURIComponent(name)}`)).some((part) => part.name === name && part.state === "waiting");
    for (const [name, javaScriptEnabled] of [["by-form.stl", false], ["by-script.stl", true]]) {
      const page = await open(browser, base, PAGES.drop, { javaScriptEnabled });
      await page.fill("main input[name=copies]", "2");
      await page.fill("main input[name=order]", "Form & Co");
      await page.setInputFiles("main input[type=file]", { name, mimeType: "model/stl", buffer: readFileSync(farm.sample) });
      await page.getByRole("button", { name: /^Add to/ }).click();
      await page.getByText(`${name} is in the hot folder`).waitFor({ timeout: 30000 });
      await until(`${name} waits`, () => waits(name));
      const [part] = await api(`/api/v1/parts?name=${name}`);
      assert.deepEqual([part.copies, part.order], [2, "Form & Co"], JSON.stringify(part));
      clean(page);
      await page.context().close();
    }
    const page = await open(browser, base, PAGES.farm);
    const card = page.locator(`section[aria-label="${farm.machine}"]`), bytes = readFileSync(farm.sample).toString("base64");
    const files = await page.evaluateHandle((text) => { const all = new DataTransfer(); all.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], "by-drop.stl")); return all; }, bytes);
    for (const kind of ["dragover", "drop"]) await card.dispatchEvent(kind, { dataTransfer: files });
    // The sheet says of each machine when it could be done, and what it adds; the soonest comes first.
    const sheet = page.getByRole("dialog", { name: "Which machine?" }), choice = sheet.getByRole("button", { name: new RegExp(`^${farm.machine}`) });
    await choice.getByText(/done .+, adds [\d.]+ mm/).waitFor({ timeout: 60000 });
    await sheet.locator("li").first().locator(".chip", { hasText: "soonest" }).waitFor({ timeout: 60000 });
    await choice.click();
    assert.match(await card.locator(".chosen").innerText(), /by-drop\.stl, \d+ kB/);
    await card.getByRole("button", { name: /^Add to/ }).click();
    await card.getByText("by-drop.stl is in the hot folder").waitFor({ timeout: 30000 });
    await until("by-drop.stl waits", () => waits("by-drop.stl"));
    clean(page);
    await page.context().close();
  },

  async "an open build is shown before it is published"() {
    const page = await open(browser, base, PAGES.open);
    assert.ok(await drawn(page) > 0);
    assert.ok((await pixels(page)).colours > 50);
    clean(page);
    await page.context().close();
  },

  async "a dropped part is seen without loading the page again"() {
    const page = await open(browser, base, PAGES.farm);
    await page.evaluate(() => { globalThis.same = true; });
    const card = page.locator(`section[aria-label="${farm.machine}"]`);
    const before = await card.innerText();
    const outside = join(farm.root, "sending-live");
    copyFileSync(farm.sample, outside);
    renameSync(outside, join(farm.inbox, "seen-live.stl"));
    await until("the card changes", async () => /Waiting/.test(await card.innerText()) && (await card.innerText()) !== before);
    const count = (text) => Number(/(\d+) cop/.exec(text.slice(text.indexOf("Waiting")))?.[1]);
    await until("one copy more waits", async () => count(await card.innerText()) === count(before) + 1);
    assert.equal(await page.evaluate(() => globalThis.same), true, "the page was loaded again");
    clean(page);
    await page.context().close();
  },

  async "a page with a filter changes too, and what is being typed stays"() {
    const page = await open(browser, base, `/parts?machine=${farm.machine}`);
    const drop = (name) => {
      const outside = join(farm.root, `sending-${name}`);
      copyFileSync(farm.sample, outside);
      renameSync(outside, join(farm.inbox, name));
    };
    drop("filtered.stl");
    await page.getByRole("cell", { name: "filtered.stl" }).waitFor({ timeout: 30000 });
    await page.locator("main input[name=name]").focus();
    await page.keyboard.type("typ");
    drop("behind.stl");
    await until("the part waits", async () => (await (await fetch(`${base}/parts?machine=${farm.machine}`)).text()).includes("behind.stl"));
    await page.waitForTimeout(2500);
    assert.equal(await page.getByRole("cell", { name: "behind.stl" }).count(), 0, "nothing moves under the typing hand");
    await page.keyboard.type("ing");
    await page.evaluate(() => document.activeElement.blur());
    await page.getByRole("cell", { name: "behind.stl" }).waitFor({ timeout: 30000 });
    assert.equal(await page.inputValue("main input[name=name]"), "typing");
    clean(page);
    await page.context().close();
  },

  async "a build's page changes around the 3D view"() {
    const page = await open(browser, base, PAGES.open);
    await drawn(page);
    await page.evaluate(() => { document.querySelector("#view").dataset.same = "yes"; });
    const copies = () => page.locator(".figure", { hasText: "copies" }).innerText();
    const before = await copies();
    const outside = join(farm.root, "sending-around");
    copyFileSync(farm.sample, outside);
    renameSync(outside, join(farm.inbox, "around.stl"));
    await until("the copies change", async () => (await copies()) !== before);
    await page.getByRole("alert").getByText("Something else stands in this build now").waitFor();
    assert.equal(await page.getAttribute("#view", "data-same"), "yes", "the 3D view stays");
    assert.ok((await pixels(page)).colours > 50, "the 3D view is still drawn");
    clean(page);
    await page.context().close();
  },

  async "a page without connection says so, and goes on when there is one"() {
    const page = await open(browser, base, PAGES.farm);
    const alert = page.locator("#lost");
    // Closes the open stream in the same way as the end of the daemon does.
    await page.context().route("**/live", (route) => route.abort());
    await page.context().setOffline(true);
    await page.evaluate(() => dispatchEvent(new Event("online")));
    await alert.waitFor({ timeout: 30000 });
    assert.match(await alert.innerText(), /^No connection to the farm since \d\d:\d\d [A-Z]/);
    assert.equal(await page.locator(".daemon").isVisible(), false, "nobody says that the daemon runs");
    await page.context().setOffline(false);
    await page.context().unroute("**/live");
    await alert.waitFor({ state: "detached", timeout: 30000 });
    assert.equal(await page.locator(".daemon").isVisible(), true);
    assert.deepEqual(page.wrong.filter((wrong) => !/Failed to load resource/.test(wrong)), []);
    await page.context().close();
  },

  async "pause and resume by button, and by the undo of what was just done"() {
    const page = await open(browser, base, PAGES.farm);
    const card = page.locator(`section[aria-label="${farm.machine}"]`), toast = page.locator(".toast");
    await card.getByRole("button", { name: /^Pause/ }).click();
    await card.getByText(/Paused by dashboard/).waitFor({ timeout: 30000 });
    await card.getByRole("button", { name: /^Resume/ }).click();
    await card.getByRole("button", { name: /^Pause/ }).click();
    await card.getByText(/Paused by dashboard/).waitFor({ timeout: 30000 });
    assert.match(await toast.innerText(), /paused/);
    assert.deepEqual(await violations(page), []);
    await toast.getByRole("button", { name: "Undo" }).click();
    await card.getByRole("button", { name: /^Pause/ }).waitFor({ timeout: 30000 });
    assert.match(await toast.innerText(), /runs again/);
    clean(page);
    await page.context().close();
  },

  async "flush by button publishes a build, also without JavaScript"() {
    const before = builds();
    const page = await open(browser, base, PAGES.farm, { javaScriptEnabled: false });
    assert.ok((await page.innerText("main")).includes("Waiting"), "the page is readable without JavaScript");
    await page.locator(`section[aria-label="${farm.machine}"]`).getByRole("link", { name: /^Flush/ }).click();
    assert.match(await page.innerText("main"), /copies of \d+ parts wait\. The layout so far holds \d+ of them and stands at [\d.]+ mm/);
    await page.getByRole("button", { name: /^Flush now/ }).click();
    await until("one more build is in the queue folder", () => builds() === before + 1);
    await until("the ledger has it", async () => (await api("/api/v1/builds")).filter((b) => b.published_at).length === before + 1);
    await page.context().close();
    return `${before} builds before, ${builds()} after`;
  },

  async "an order without the form's key is refused"() {
    const body = new URLSearchParams({ key: "guessed", kind: "flush", machine: farm.machine });
    const answer = await fetch(`${base}/commands`, { method: "POST", body, headers: { origin: base } });
    assert.equal(answer.status, 403);
    const foreign = await fetch(`${base}/commands`, { method: "POST", body, headers: { origin: "https://elsewhere.example" } });
    assert.equal(foreign.status, 403);
  },

  async "history shows the figures of the ledger, filtered and sorted"() {
    const page = await open(browser, base, "/history?sort=height");
    const shown = await page.$$eval("[aria-label=Builds] tbody tr", (rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent.trim())));
    const heads = await page.$$eval("[aria-label=Builds] thead th", (heads) => heads.map((head) => head.textContent.trim()));
    const at = (head) => { assert.ok(heads.includes(head), `${head} is none of ${heads}`); return heads.indexOf(head); };
    const known = new Map(farm.history.map((row) => [String(row.build), row]));
    const heights = shown.map((cells) => Number(cells[at("Height, mm")])).filter((height) => height > 0);
    assert.deepEqual(heights, [...heights].sort((a, b) => a - b), "sorted by height");
    assert.ok(heights.length >= 2);
    for (const [build, row] of known) {
      const cells = shown.find((cells) => cells[0] === build);
      assert.ok(cells, `build ${build}`);
      assert.equal(cells[at("Height, mm")], row.height_mm.toFixed(2));
      assert.equal(cells[at("Used, %")], (100 * row.height_mm / row.volume_z_mm).toFixed(1));
      assert.equal(Number(cells[at("Copies")]), row.copies);
    }
    const sum = Number(await page.textContent("[aria-label=Heights] tbody tr:last-child td:nth-child(2)"));
    assert.ok(Math.abs(sum - heights.reduce((sum, height) => sum + height, 0)) < 0.01 * heights.length, `${sum} mm in all`);
    assert.ok(await page.locator(".charts svg polyline").count() >= 3, "three charts");
    const csv = await (await fetch(`${base}/history.csv?sort=height`)).text();
    assert.equal(csv.trim().split("\n").length, shown.length + 1);
    clean(page);
    await page.context().close();
    const none = await open(browser, base, "/history?since=1999-01-01&until=1999-12-31");
    assert.match(await none.innerText("main"), /No builds/);
    await none.context().close();
  },

  async "a build is broken out by touch on a tablet, and another person sees it at once"() {
    const path = `/builds/${farm.second}/break-out`;
    const ann = await open(browser, base, path, { width: 800, hasTouch: true });
    await ann.fill("input[name=name]", "Ann");
    await ann.getByRole("button", { name: "That is me" }).tap();
    await ann.getByText("You are Ann.").waitFor();
    const ben = await open(browser, base, path, { width: 390, javaScriptEnabled: true });
    await ben.fill("input[name=name]", "Ben");
    await ben.getByRole("button", { name: "That is me" }).click();
    await ben.getByText("You are Ben.").waitFor();
    const picture = ann.locator(".step-sights img");
    assert.ok(await picture.evaluate((image) => image.complete && image.naturalWidth > 100), "the part has a picture");
    const button = ann.getByRole("button", { name: /^Out/ });
    const box = await button.boundingBox();
    assert.ok(box.height >= 64 && box.width >= 96, `${box.width} x ${box.height} is small for a thumb`);
    const first = await ann.locator(".step h2").innerText();
    await button.tap();
    await ann.getByText(/^1 of \d+ cop/).waitFor();
    assert.notEqual(await ann.locator(".step h2").innerText(), first, "the next copy is asked for");
    await ben.getByText(/^1 of \d+ cop/).waitFor({ timeout: 30000 });
    await ann.getByRole("button", { name: /^Bad/ }).tap();
    await ann.getByText(/1 good, 1 bad/).waitFor();
    await ann.getByRole("button", { name: /^Undo/ }).tap();
    await ann.getByText(/1 good, 0 bad/).waitFor();
    clean(ann);
    clean(ben);
    await ben.context().close();
    await ann.context().close();
    // The rest without JavaScript.
    const plain = await open(browser, base, path, { width: 800, javaScriptEnabled: false });
    await plain.getByRole("button", { name: /^Not found/ }).click();
    await plain.getByText(/1 not found/).waitFor();
    await plain.getByText(/^Still in the cake:/).click();
    await plain.getByRole("button", { name: "All of these are out and good" }).click();
    await plain.getByRole("button", { name: /^Tell it: printed/ }).click();
    // Its file still lies in the queue: it is taken out before the copy that was not found is printed again.
    await plain.getByText(/lies untouched in the queue/).waitFor();
    await plain.getByRole("button", { name: /do it anyway/ }).click();
    await plain.getByText(/is taken out of the queue/).waitFor();
    const told = async () => { const build = await api(`/api/v1/builds/${farm.second}`); return build.build?.state ?? build.state; };
    for (let tries = 0; tries < 100 && await told() !== "complete"; tries += 1) await plain.waitForTimeout(200);
    assert.equal(await told(), "complete");
    await plain.goto(`${base}/builds/${farm.second}`);
    await plain.getByText(/broken out/i).first().waitFor();
    await plain.context().close();
  },
};
