// Shared by all checks: a Chromium with software rendering, and pages that report their errors.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Starts the Chromium that is asked for. */
export function start(executablePath) {
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
}

/** A page that keeps what a customer must never see: errors, dialogs, requests to other hosts; and what it loaded, bytes. */
export async function open(browser, base, path, { width = 1280, scheme = "light", ...options } = {}) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme: scheme, ...options });
  const page = await context.newPage();
  page.wrong = [];
  page.bytes = 0;
  page.on("console", (message) => message.type() === "error" && page.wrong.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => page.wrong.push(`error: ${error.message}`));
  page.on("dialog", (dialog) => { page.wrong.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (!["data:", "blob:"].includes(url.protocol) && url.origin !== base) page.wrong.push(`request to ${url.origin}`);
  });
  page.on("response", async (response) => {
    if (!response.url().endsWith("/live")) page.bytes += (await response.body().catch(() => "")).length;
  });
  const answer = await page.goto(base + path, { waitUntil: "load" });
  if (answer.status() !== 200) page.wrong.push(`status ${answer.status()}`);
  return page;
}

/** Violations that axe-core finds, a line each: in a part of the page, or by some of its rules, if asked. */
export async function violations(page, { within = "html", rules } = {}) {
  if (!await page.evaluate(() => "axe" in globalThis)) await page.evaluate(axe);
  const runOnly = rules && { type: "rule", values: rules };
  const found = await page.evaluate(([within, runOnly]) => globalThis.axe.run(within, runOnly ? { runOnly } : {}), [within, runOnly]);
  return found.violations.map((v) => `${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map((n) => n.target.join(" ")).join("; ")}`);
}

/** Texts that reach out of what they stand in, or are cut by it, a line each. What is cut by dots may be where a press shows all of it. */
export function spilled(page) {
  return page.evaluate(() => {
    const found = [], range = document.createRange(), walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const parent = node.parentElement;
      if (!node.textContent.trim() || !parent.checkVisibility() || parent.closest(".unseen, .skip, svg, script, option")) continue;
      let box = parent;
      while (["inline", "contents"].includes(getComputedStyle(box).display)) box = box.parentElement;
      const style = getComputedStyle(box), place = box.getBoundingClientRect();
      if (place.width <= 1 || ["auto", "scroll"].includes(style.overflowX) || style.textOverflow === "ellipsis" && box.closest("a[href], button[popovertarget]")) continue;
      range.selectNodeContents(node);
      const [left, right] = [place.left + Number.parseFloat(style.borderLeftWidth), place.right - Number.parseFloat(style.borderRightWidth)];
      if ([...range.getClientRects()].some((rect) => rect.left < left - 1 || rect.right > right + 1)) found.push(`${box.tagName}.${box.className}: ${node.textContent.trim().slice(0, 60)}`);
    }
    const pen = document.createElement("canvas").getContext("2d");
    for (const input of document.querySelectorAll("input[placeholder]")) {
      const style = getComputedStyle(input);
      pen.font = style.font;
      const room = input.clientWidth - Number.parseFloat(style.paddingLeft) - Number.parseFloat(style.paddingRight);
      if (input.checkVisibility() && pen.measureText(input.placeholder).width > room) found.push(`placeholder: ${input.placeholder}`);
    }
    return found;
  });
}

/** Waits until the 3D view has drawn; the number of parts in it. */
export async function drawn(page) {
  await page.waitForFunction(() => document.querySelector("#view")?.dataset.drawn, null, { timeout: 30000 });
  return page.evaluate(() => Number(document.querySelector("#view").dataset.drawn));
}

/** What is on the canvas: how many colours, how many red pixels, and a number that changes with the picture. */
export function pixels(page) {
  return page.evaluate(async () => {
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const canvas = document.querySelector("#view canvas");
    const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const colours = new Set();
    let red = 0, sum = 0;
    for (let at = 0; at < data.length; at += 4) {
      const [r, g, b] = [data[at], data[at + 1], data[at + 2]];
      colours.add((r << 16) | (g << 8) | b);
      if (r > 110 && g < 30 && b < 30) red += 1;
      sum = (sum * 31 + r + 256 * g + 65536 * b) % 2147483647;
    }
    return { colours: colours.size, red, sum };
  });
}
