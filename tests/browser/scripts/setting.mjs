// What all checks of the pages share: the farm, as tests/browser/pages.rs describes it, and a browser.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { start } from "./browser.mjs";

export const farm = JSON.parse(process.argv[2]);
export const { base } = farm;
export const browser = await start(farm.chromium);
export const PAGES = { farm: "/", components: "/components", build: `/builds/${farm.build}`, pick: `/builds/${farm.build}/pick`, breakOut: `/builds/${farm.build}/break-out`, open: `/builds/${farm.open}`, history: "/history",
  parts: "/parts", part: `/parts/${farm.part}`, record: `/parts/${farm.part}/record`, orders: "/orders", order: `/orders/${encodeURIComponent(farm.order)}`, refused: `/parts/${farm.refused}`, search: "/search?q=e", flush: `/machines/${farm.machine}/flush`, drop: `/machines/${farm.machine}/drop`, signIn: "/sign-in", month: "/month", help: "/help", found: "/help?q=queue", chapter: "/help/integrator", symptoms: "/help/symptoms", long: `/orders/Maschinenbau_Friedrich_Oberhausen_und_Soehne_GmbH_Auftrag_4711`, missing: "/parts/999999" };
export const SPATIAL = ["build", "open"];
export const WIDTHS = [390, 800, 1440];
export const builds = () => readdirSync(farm.queue).filter((name) => name.endsWith(".build.3mf")).length;
export const api = async (path) => (await fetch(base + path)).json();
export const until = async (what, holds, secs = 60) => {
  for (const end = Date.now() + 1000 * secs; Date.now() < end; await new Promise((done) => setTimeout(done, 100))) if (await holds()) return;
  assert.fail(`waited ${secs} s in vain until ${what}`);
};
export const clean = (page) => assert.deepEqual(page.wrong, []);
