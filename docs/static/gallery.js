// Reports of the gallery open in place of their pictures; without this script, and in other tabs, links lead to them.
// Cards play small films: under the pointer and with the focus, or where there is no pointer while they are in sight.
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

/** Where the films are: beside this script. */
const FILMS = new URL("films/", document.currentScript.src);

/** How much of a card is in sight when it plays by itself. */
const SEEN = 0.8;

/** Lets a card play its film, or shows its picture again. Films are loaded when they are first played. */
function playing(card) {
  const picture = card.querySelector("img");
  const still = picture.src;
  const [, name] = still.match(/([^/]+)\.png$/) ?? [];
  let film = null;
  let isWanted = false;
  return (wanted) => {
    isWanted = wanted;
    if (!wanted) picture.src = still;
    if (!wanted || !name) return;
    film ??= Object.assign(new Image(), { src: new URL(`${name}.webp`, FILMS).href });
    // A film that cannot be loaded leaves the picture as it is.
    film.decode().then(() => { if (isWanted) picture.src = film.src; }, () => {});
  };
}

if (!matchMedia("(prefers-reduced-motion: reduce)").matches) {
  const players = new Map([...document.querySelectorAll(".scene-card")].map((card) => [card, playing(card)]));
  if (matchMedia("(hover: none)").matches) {
    const observer = new IntersectionObserver(
      (entries) => entries.forEach(({ target, isIntersecting }) => players.get(target)(isIntersecting)),
      { threshold: SEEN },
    );
    for (const card of players.keys()) observer.observe(card);
  } else {
    for (const [card, play] of players) {
      for (const begin of ["pointerenter", "focusin"]) card.addEventListener(begin, () => play(true));
      for (const end of ["pointerleave", "focusout"]) card.addEventListener(end, () => play(false));
    }
  }
}
