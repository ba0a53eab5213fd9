// Starts what a report holds: views and curves, when they are first shown, and what the reader picks.

import { clock } from "lissom/clock.js";
import { follow } from "lissom/paper.js";
import { Player } from "lissom/player.js";
import { figure } from "lissom/plots.js";
import { unpack } from "lissom/unpack.js";

/** Between figures that are not in sight yet, milliseconds. */
const PAUSE = 50;

const started = new Set();

/** What draws each holder anew. */
const redraws = new Map();

async function start(holder) {
  if (started.has(holder) || holder.closest("[hidden]")) return;
  started.add(holder);
  try {
    const told = await unpack(JSON.parse(document.getElementById(holder.dataset.source).textContent));
    if (holder.classList.contains("player")) {
      const player = new Player(holder, told, clock(holder.dataset.clock), holder.getAttribute("aria-label"));
      holder.player = player;
      player.resize();
      redraws.set(holder, () => player.relaid());
    } else redraws.set(holder, figure(holder, told, clock(told.clock)));
    holder.dataset.state = "ready";
  } catch (error) {
    holder.dataset.state = "failed";
    holder.textContent = `This cannot be shown: ${error.message}. The numbers of the run are in its other files.`;
    console.warn(error);
  }
}

for (const choice of document.querySelectorAll(".choice")) {
  const select = choice.querySelector("select");
  const options = [...choice.querySelectorAll(".option")];
  select.addEventListener("change", () => {
    options.forEach((option, i) => {
      option.hidden = i !== select.selectedIndex;
    });
    options[select.selectedIndex].querySelectorAll(".figure, .player").forEach(start);
  });
}

follow(() => redraws.forEach((redraw) => redraw()));

// What is in sight comes first, then the rest, one by one, so that the page answers meanwhile.
const holders = [...document.querySelectorAll(".figure, .player")];
const near = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) if (isIntersecting) start(target);
}, { rootMargin: "200px" });
holders.forEach((holder) => near.observe(holder));
addEventListener("load", async () => {
  for (const holder of holders) {
    await new Promise((resolve) => setTimeout(resolve, PAUSE));
    await start(holder);
  }
});
