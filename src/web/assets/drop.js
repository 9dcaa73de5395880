// Files that are dropped onto a machine, or chosen in its form: shows what is chosen and how much of it is sent. Without this script the
// form works as any form does.
const KB = 1024, MB = KB * KB;
const size = (bytes) => (bytes < MB ? `${Math.ceil(bytes / KB)} kB` : `${(bytes / MB).toFixed(1)} MB`);
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
  said.textContent = files.length === 0 ? "" : large.length > 0 ? `${large[0].name} is larger than this farm takes (${size(most)}).`
    : `${files.length === 1 ? files[0].name : `${files.length} files`}, ${size(total)}`;
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
  request.upload.addEventListener("progress", ({ loaded, total }) => { bar.value = 100 * loaded / total; said.textContent = `${size(loaded)} of ${size(total)} sent`; });
  request.upload.addEventListener("load", () => { said.textContent = "Sent; the farm writes it down."; });
  request.addEventListener("load", async () => {
    const main = new DOMParser().parseFromString(request.responseText, "text/html").querySelector("#main");
    const answer = main?.querySelector("#answer, #problem");
    if (request.status !== 200 || !answer) return failed(answer?.textContent || `The farm answers ${request.status}.`);
    form.reset();
    await renewKey(form);
    failed([...answer.children].map((line) => line.textContent).join(" "));
    form.dataset.sent = "yes";
  });
  request.addEventListener("error", () => failed("The connection was lost. Send it again: what was added is not added twice."));
  request.open("POST", form.action);
  request.setRequestHeader("accept", "text/html");
  bar.hidden = false; button.disabled = true;
  request.send(new FormData(form));
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
  const fold = form.closest("details");
  if (fold) fold.open = true;
  form.elements.file.files = event.dataTransfer.files;
  show(form);
  form.elements.order.focus();
});
