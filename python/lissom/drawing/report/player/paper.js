// The page on paper: views are stills, all plots are drawn, in light colours and as wide as the paper.

/** Pixels of canvases for each one of the page: some 290 an inch. */
export const FINE = 3;

/** Whether the page is being printed. */
export const onPaper = () => document.documentElement.classList.contains("paper");

/** Pixels of canvases for each one of the page. */
export const sharpness = () => (onPaper() ? FINE : Math.min(devicePixelRatio || 1, 2));

/** What `read` finds while the page has its colours for paper. */
export function inLight(read) {
  const { classList } = document.documentElement;
  const isPrinted = onPaper();
  classList.add("paper");
  try {
    return read();
  } finally {
    classList.toggle("paper", isPrinted);
  }
}

/** Follow the browser: `redraw` draws everything anew, once for paper and once for the screen. */
export function follow(redraw) {
  for (const [event, is] of [["beforeprint", true], ["afterprint", false]]) {
    addEventListener(event, () => {
      document.documentElement.classList.toggle("paper", is);
      redraw();
    });
  }
}
