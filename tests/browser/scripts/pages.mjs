// Checks of the dashboard in a real browser: node pages.mjs '{"chromium": ..., "base": ..., ...}'; tests/browser/pages.rs calls it.
import { checks as actions } from "./actions.mjs";
import { checks as looks } from "./looks.mjs";
import { browser } from "./setting.mjs";

let failed = 0;
for (const [name, check] of Object.entries({ ...looks, ...actions })) {
  const began = performance.now(), secs = () => `${((performance.now() - began) / 1000).toFixed(1)} s`;
  try {
    const told = await check();
    console.log(`ok: ${name}, ${secs()}${told ? ` (${told})` : ""}`);
  } catch (error) {
    failed += 1;
    console.log(`FAILED: ${name}, ${secs()}: ${error.message}`);
  }
}
await browser.close();
process.exit(failed ? 1 : 0);
