// Pictures of the pages for the documentation.
import { join } from "node:path";
import { drawn, open } from "./browser.mjs";

/** Waits until every picture of a page that has room is there, also those that are loaded when they come into sight. */
async function pictured(page) {
  await page.evaluate(() => document.querySelectorAll("img").forEach((image) => { image.loading = "eager"; }));
  await page.waitForFunction(() => [...document.images].every((image) => image.getClientRects().length === 0 || image.complete && image.naturalWidth > 0), null, { timeout: 60000 });
}

/** A picture of each page, [name, address, width, scheme], in a folder. */
export async function shoot(browser, base, pages, folder) {
  for (const [name, path, width, scheme] of pages) {
    const page = await open(browser, base, path, { width, scheme });
    if (await page.locator("#view").count() > 0) await drawn(page);
    await pictured(page);
    await page.screenshot({ path: join(folder, `${name}-${width}-${scheme}.png`), fullPage: true });
    await page.context().close();
  }
}
