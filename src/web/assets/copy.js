// The button beside a text copies it. Without this script the button does not show, and the text can be selected.
const show = () => document.querySelectorAll("button[data-copies][hidden]").forEach((button) => { button.hidden = false; });

async function copy(button) {
  const text = document.getElementById(button.dataset.copies);
  // A page that came without TLS has no clipboard.
  try { await navigator.clipboard.writeText(text.textContent); } catch { getSelection().selectAllChildren(text); document.execCommand("copy"); }
  button.textContent = JSON.parse(document.querySelector("#texts").textContent).copied;
}

document.addEventListener("click", (event) => {
  const button = event.target.closest?.("button[data-copies]");
  if (button) copy(button);
});
new MutationObserver(show).observe(document.querySelector("#main"), { childList: true });
show();
