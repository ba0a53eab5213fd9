// Reports of the gallery open in place of their pictures; without this script, and in other tabs, links lead to them.
"use strict";

document.addEventListener("click", (event) => {
  const link = event.target.closest("a.scene-report");
  if (!link || event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
  event.preventDefault();
  const frame = document.createElement("iframe");
  frame.src = link.href;
  frame.title = link.title;
  frame.className = "scene-report";
  link.replaceWith(frame);
  frame.focus();
});
