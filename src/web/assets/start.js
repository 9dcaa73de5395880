// Loads the 3D view of a build after its picture, so that a slow line shows the picture first; at the latest after a while.
const LATEST_MS = 5000;
const section = document.querySelector("#view"), poster = section?.querySelector(".poster img");
let begun = false;

function begin() {
  if (begun) return;
  begun = true;
  import(section.dataset.script).catch(() => { section.querySelector("#hover").textContent = JSON.parse(document.querySelector("#texts").textContent).no_script; });
}

if (section && (!poster || poster.complete)) begin();
else if (section) {
  for (const end of ["load", "error"]) poster.addEventListener(end, begin);
  setTimeout(begin, LATEST_MS);
}
