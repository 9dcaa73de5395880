// Keeps a page up to date: when the farm changes, the page is fetched again and its content put in place.
const main = document.querySelector("#main");
const stays = document.querySelector("#view, .band");
let busy = false;
async function refresh() {
  const typing = document.activeElement && main.contains(document.activeElement) && /^(INPUT|SELECT)$/.test(document.activeElement.tagName);
  if (busy || typing || document.hidden) return;
  busy = true;
  try {
    const answer = await fetch(location.href, { headers: { accept: "text/html" } });
    if (answer.ok) {
      const fresh = new DOMParser().parseFromString(await answer.text(), "text/html").querySelector("#main");
      const focus = document.activeElement?.textContent;
      if (fresh && fresh.innerHTML !== main.innerHTML) {
        main.replaceChildren(...fresh.childNodes);
        if (focus) [...main.querySelectorAll("button, a")].find((e) => e.textContent === focus)?.focus();
      }
    }
  } catch { /* the daemon restarts: the next change comes when it is back */ }
  busy = false;
}
if (main && !stays && location.search === "") {
  const events = new EventSource("/live");
  events.addEventListener("changed", refresh);
  document.addEventListener("visibilitychange", refresh);
}
