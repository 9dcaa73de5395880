// Keeps a page up to date: when the farm changes, and once a minute, fetches the page again and replaces its content. Shows a
// message when the page cannot be updated.
const EVERY_MS = 60000, AGAIN_MS = 5000, PATIENCE_MS = 20000, TOAST_MS = 8000;
const main = document.querySelector("#main");
let events = null, again = 0, busy = false, dirty = false, lost = null, zone = "";
// What this script says comes with the page, in its language.
const texts = JSON.parse(document.querySelector("#texts")?.textContent ?? "{}");
const lang = document.documentElement.lang === "en" ? "en-GB" : document.documentElement.lang;

const OPEN = CSS.supports("selector(:popover-open)") ? "details[open] form, :popover-open form" : "details[open] form";
// A button that is replaced between press and release gets no click.
let pressed = false;
const isInUse = () => pressed || main.querySelector(OPEN) || [...main.querySelectorAll("input[type=file]")].some((input) => input.files.length > 0) || main.contains(document.activeElement) && /^(INPUT|SELECT|TEXTAREA)$/.test(document.activeElement.tagName)
  && !document.activeElement.closest("#view");

function say(id, text, link) {
  let line = document.getElementById(id);
  if (!line) {
    line = Object.assign(document.createElement("p"), { id, className: "bad" });
    line.setAttribute("role", "alert");
    document.querySelector("header").append(line);
  }
  line.textContent = text;
  if (link) line.append(" ", Object.assign(document.createElement("a"), { href: location.href, textContent: link, onclick: (e) => { e.preventDefault(); location.reload(); } }));
}

/** A time of day in the farm's time zone, with its mark; in that of the browser while the farm's is not known. */
function clock(time) {
  const format = { hour: "2-digit", minute: "2-digit", hourCycle: "h23", timeZoneName: "short" };
  try { return time.toLocaleTimeString(lang, { ...format, timeZone: zone || undefined }); } catch { return time.toLocaleTimeString(lang, format); }
}

function disconnected() {
  if (lost) return;
  lost = new Date();
  document.body.dataset.lost = "";
  say("lost", texts.lost.replace("{time}", clock(lost)));
}

function connected() {
  lost = null;
  delete document.body.dataset.lost;
  document.getElementById("lost")?.remove();
}

/** Replaces the content; the 3D view and filled-in forms stay as they are. */
function place(fresh) {
  const view = main.querySelector(":scope > #view"), newView = fresh.querySelector(":scope > #view");
  if (newView && !view) return location.reload(); // It needs a script that this page does not have.
  const form = main.querySelector("form.filters"), newForm = fresh.querySelector("form.filters");
  if (form && newForm) newForm.replaceWith(form);
  if (!view || !newView) return main.replaceChildren(...fresh.childNodes);
  if (newView.dataset.version !== view.dataset.version) say("changed", texts.changed, texts.load_again);
  const nodes = [...fresh.childNodes], at = nodes.indexOf(newView);
  for (const node of [...main.childNodes]) if (node !== view) node.remove();
  view.before(...nodes.slice(0, at));
  view.after(...nodes.slice(at + 1));
}

/** The content to compare: each form has another key whenever the page is made. */
const contentOf = (place) => place.innerHTML.replaceAll(/name="key" value="[^"]*"/g, "");

let shown = null;
async function fetched() {
  const answer = await fetch(location.href, { headers: { accept: "text/html", "nestd-refresh": "1" }, signal: AbortSignal.timeout(PATIENCE_MS) });
  if (answer.status === 401) return location.reload(); // The form to sign in stands in place of the page.
  if (!answer.ok) throw new Error(`the farm answers ${answer.status}`);
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html").querySelector("#main");
  if (!fresh) throw new Error("another page came, perhaps that of a login");
  const content = contentOf(fresh);
  if (content === shown || isInUse()) { dirty ||= isInUse(); return; }
  const before = shown ?? contentOf(main);
  shown = content;
  if (shown === before) return;
  const opened = new Set([...main.querySelectorAll("details[open] > summary")].map((summary) => summary.textContent.replace(/\d+/g, "")));
  const focus = main.contains(document.activeElement) && !document.activeElement.closest("#view") ? document.activeElement.textContent : null;
  place(fresh);
  for (const summary of main.querySelectorAll("details > summary")) if (opened.has(summary.textContent.replace(/\d+/g, ""))) summary.parentElement.open = true;
  if (focus) [...main.querySelectorAll("button, a")].find((e) => e.textContent === focus)?.focus();
}

/** Shows new content; a change that comes in the meantime, or while a person types, is shown afterwards. */
async function refresh() {
  dirty = true;
  if (busy) return;
  busy = true;
  while (dirty && !document.hidden && !isInUse()) {
    dirty = false;
    try { await fetched(); connected(); } catch { disconnected(); }
  }
  busy = false;
}

function listen() {
  clearTimeout(again);
  events?.close();
  events = null;
  // A browser allows few connections to a host: a hidden page closes its own.
  if (document.hidden) return;
  // Where a build is broken out, the node that keeps the screens apart tells what changes.
  events = new EventSource(`${/^\/builds\/\d+(?=\/break-out)/.exec(location.pathname)?.[0] ?? ""}/live`);
  events.addEventListener("changed", (event) => { zone = event.data; refresh(); });
  events.addEventListener("error", () => {
    disconnected();
    if (events?.readyState === EventSource.CLOSED) again = setTimeout(listen, AGAIN_MS);
  });
}

// The key / leads to the search, from everywhere but a field.
addEventListener("keydown", (event) => {
  if (event.key !== "/" || event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
  event.preventDefault();
  document.querySelector("nav input[type=search]")?.focus();
});

/** Says for a while what a form did that led back here, with the button that takes it back. Under pointer and focus it stays. */
async function toast() {
  const number = /(?:^|; )told=([^;]+)/.exec(document.cookie)?.[1];
  if (!number) return;
  document.cookie = "told=; Path=/; Max-Age=0; SameSite=Strict";
  const answer = await fetch(`/told/${encodeURIComponent(number)}`, { headers: { accept: "text/html" } });
  const told = new DOMParser().parseFromString(await answer.text(), "text/html"), said = told.querySelector("#answer");
  if (!answer.ok || !said) return;
  const box = Object.assign(document.createElement("div"), { className: "toast" });
  box.setAttribute("role", "status");
  document.body.append(box);
  box.append(...said.childNodes, ...told.querySelectorAll("#undo form"));
  const end = () => (box.matches(":hover, :focus-within") ? setTimeout(end, TOAST_MS) : box.remove());
  setTimeout(end, TOAST_MS);
}
toast().catch(() => { /* The page shows what was done. */ });

// An error page, the answer to a form and the form to sign in are not updated.
if (main && !document.querySelector("#problem, #answer, #sign-in")) {
  main.addEventListener("toggle", () => { if (dirty) refresh(); }, true); // of folds and sheets
  main.addEventListener("focusout", () => setTimeout(() => { if (dirty) refresh(); }));
  const release = () => setTimeout(() => { pressed = false; if (dirty) refresh(); }); // after the click
  addEventListener("pointerdown", () => { pressed = true; }, true);
  for (const end of ["pointerup", "pointercancel", "dragend"]) addEventListener(end, release, true);
  document.addEventListener("visibilitychange", () => { listen(); if (!document.hidden) refresh(); });
  addEventListener("online", listen);
  setInterval(refresh, EVERY_MS);
  listen();
}
