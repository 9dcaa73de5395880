// Files that are dropped onto the board: a sheet says of each machine when they could be done and how much height they add, and one of
// them is chosen. Shows what is chosen in the form of a machine, and how much of it is sent. Without this script the form works as any
// form does.
const KB = 1024, MB = KB * KB;
// What this script says comes with the page, in its language; values stand in braces.
const texts = JSON.parse(document.querySelector("#texts").textContent);
const lang = document.documentElement.lang === "en" ? "en-GB" : document.documentElement.lang;
const text = (name, values = {}) => texts[name].replace(/\{(\w+)\}/g, (_, key) => values[key] ?? "");
const fixed = (number) => number.toLocaleString(lang, { minimumFractionDigits: 1, maximumFractionDigits: 1, useGrouping: false });
const size = (bytes) => (bytes < MB ? `${Math.ceil(bytes / KB)} kB` : `${fixed(bytes / MB)} MB`);
const formOf = (target) => {
  const place = target instanceof Element && target.closest("section.machine, main");
  return place && (place.matches("form.drop") ? place : place.querySelector("form.drop"));
};

/** Says what is chosen, and what is too large before it is sent. */
function show(form) {
  const files = [...form.elements.file.files], most = Number(form.dataset.maxBytes);
  const large = files.filter((file) => file.size > most);
  const total = files.reduce((sum, file) => sum + file.size, 0);
  const said = form.querySelector(".chosen");
  said.textContent = files.length === 0 ? "" : large.length > 0 ? text("too_large", { name: large[0].name, size: size(most) })
    : `${files.length === 1 ? files[0].name : text("files", { count: files.length })}, ${size(total)}`;
  form.querySelector("button").disabled = large.length > 0;
}

/** The form has been carried out under its key: what is dropped next is another one. */
async function renewKey(form) {
  try {
    const page = new DOMParser().parseFromString(await (await fetch(location.href, { headers: { accept: "text/html" } })).text(), "text/html");
    form.elements.key.value = page.querySelector("form.drop input[name=key]").value;
  } catch { /* The farm says then that the page must be loaded again. */ }
}

function send(form) {
  const said = form.querySelector(".chosen"), bar = form.querySelector("progress"), button = form.querySelector("button");
  const request = new XMLHttpRequest();
  const failed = (text) => { said.textContent = text; bar.hidden = true; button.disabled = false; };
  request.upload.addEventListener("progress", ({ loaded, total }) => { bar.value = 100 * loaded / total; said.textContent = text("sent_of", { sent: size(loaded), all: size(total) }); });
  request.upload.addEventListener("load", () => { said.textContent = text("sent"); });
  request.addEventListener("load", async () => {
    const main = new DOMParser().parseFromString(request.responseText, "text/html").querySelector("#main");
    const answer = main?.querySelector("#answer, #problem");
    if (request.status !== 200 || !answer) return failed(answer?.textContent || text("answers", { status: request.status }));
    form.reset();
    await renewKey(form);
    failed([...answer.children].map((line) => line.textContent).join(" "));
    form.dataset.sent = "yes";
  });
  request.addEventListener("error", () => failed(text("connection_lost")));
  request.open("POST", form.action);
  request.setRequestHeader("accept", "text/html");
  bar.hidden = false; button.disabled = true;
  request.send(new FormData(form));
}

/** Puts files into the form of a machine. */
function give(form, files) {
  const fold = form.closest("details");
  if (fold) fold.open = true;
  form.elements.file.files = files;
  show(form);
  form.elements.order.focus();
}

const node = (tag, properties, ...children) => { const made = Object.assign(document.createElement(tag), properties); made.append(...children); return made; };

/** Asks in a sheet which machine takes files. A browser tells what a file holds only once it is dropped. `target` = where they were. */
function offer(files, target, board) {
  const machines = [...document.querySelectorAll("form.drop")].map((form) => form.dataset.machine);
  machines.sort((a, b) => Number(b === target.dataset.machine) - Number(a === target.dataset.machine));
  const names = [...files].map((file) => file.name).join(", ");
  const close = node("button", { type: "button", className: "close", textContent: text("close") });
  const list = node("ul", { className: "rows" });
  const sheet = node("div", { className: "sheet-box", popover: "auto" }, node("div", { className: "sheet-head" }, node("h2", { textContent: text("which_machine") }), close), node("p", { textContent: names }), list);
  sheet.setAttribute("role", "dialog");
  sheet.setAttribute("aria-label", text("which_machine"));
  const ending = new AbortController();
  const answers = machines.map((name) => {
    const said = node("span", { className: "row-more", textContent: text("asking") });
    const choice = node("button", { type: "button", className: "row" }, node("span", { className: "row-name", textContent: name }), said);
    choice.addEventListener("click", () => { sheet.hidePopover(); give(document.querySelector(`form.drop[data-machine="${CSS.escape(name)}"]`), files); });
    list.append(node("li", {}, choice));
    return { name, said };
  });
  close.addEventListener("click", () => sheet.hidePopover());
  sheet.addEventListener("toggle", ({ newState }) => { if (newState === "closed") { ending.abort(); sheet.remove(); } });
  document.body.append(sheet);
  sheet.showPopover();
  list.querySelector("button").focus();
  quoteAll(answers, files, board.dataset.zone, ending.signal);
}

/** Asks one machine after the other: each searches. */
async function quoteAll(answers, files, zone, signal) {
  const known = new Map();
  for (const { name, said } of answers) {
    const form = new FormData();
    form.append("quote", JSON.stringify({ machine: name, lines: [...files].map((file) => ({ name: file.name })) }));
    for (const file of files) form.append("file", file);
    try {
      const answer = await fetch("/api/v1/quote", { method: "POST", body: form, headers: { accept: "application/json" }, signal });
      const quote = await answer.json();
      if (answer.ok && quote.earliest_at) known.set(said.closest("li"), quote.earliest_at);
      said.textContent = answer.ok ? inWords(quote, zone) : quote.detail || text("answers", { status: answer.status });
    } catch (error) {
      if (error.name === "AbortError") return;
      said.textContent = text("no_answer");
    }
  }
  // The soonest first; what is not known last.
  const items = [...known.keys()].sort((a, b) => Date.parse(known.get(a)) - Date.parse(known.get(b)));
  const focused = document.activeElement;
  answers[0]?.said.closest("ul").prepend(...items);
  focused?.focus();
  if (items.length > 1) items[0].querySelector(".row-name").append(" ", node("span", { className: "chip good" }, node("i", {}), text("soonest")));
}

/** A time as the board says it: `tomorrow 19:10`, in the zone of the farm. */
function nearTime(at, zone) {
  const format = { timeZone: zone || undefined };
  const day = (time) => time.toLocaleDateString("sv", format), ahead = (days) => day(new Date(Date.now() + days * 86400000));
  const clock = at.toLocaleTimeString(lang, { ...format, hour: "2-digit", minute: "2-digit", hourCycle: "h23" });
  const near = day(at) === ahead(0) ? text("today") : day(at) === ahead(1) ? text("tomorrow") : at.toLocaleDateString(lang, { ...format, weekday: "short", day: "numeric", month: "short" });
  return text("day_and_clock", { day: near, clock });
}

/** What a quote says: when all is done, how much height that adds, and whom it makes late. */
function inWords(quote, zone) {
  const late = quote.delays.length, added = quote.added_at_most_mm === null ? quote.added_mm : Math.min(quote.added_mm, quote.added_at_most_mm);
  const done = quote.earliest_at ? text("done", { time: nearTime(new Date(quote.earliest_at), zone) }) : text("no_date_known");
  const added_text = text("adds", { done, height: fixed(added) });
  return late ? `${added_text}; ${text(late === 1 ? "one_late" : "several_late", { count: late })}` : added_text;
}

addEventListener("change", ({ target }) => { if (target.matches?.("form.drop input[type=file]")) show(target.form); });
addEventListener("submit", (event) => {
  if (!event.target.matches("form.drop")) return;
  event.preventDefault();
  send(event.target);
});
addEventListener("dragover", (event) => {
  if (!event.dataTransfer?.types.includes("Files")) return;
  event.preventDefault();
  const form = formOf(event.target);
  event.dataTransfer.dropEffect = form ? "copy" : "none";
  for (const card of document.querySelectorAll(".over")) card.classList.remove("over");
  form?.closest("section.machine, main").classList.add("over");
});
addEventListener("dragleave", (event) => { if (!event.relatedTarget) for (const card of document.querySelectorAll(".over")) card.classList.remove("over"); });
addEventListener("drop", (event) => {
  if (!event.dataTransfer?.types.includes("Files")) return;
  event.preventDefault(); // Beside a machine a browser would open the file instead of the page.
  for (const card of document.querySelectorAll(".over")) card.classList.remove("over");
  const form = formOf(event.target);
  if (!form) return;
  const files = event.dataTransfer.files, board = form.closest(".board");
  if (board && HTMLElement.prototype.togglePopover) offer(files, form, board);
  else give(form, files);
});
