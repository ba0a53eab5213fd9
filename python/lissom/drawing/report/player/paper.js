// The page on paper: views are stills, all plots are drawn, in light colours and as wide as the paper.

/** Pixels of canvases for each one of the page: some 290 an inch. */
const FINE = 3;

/** Whether the page is being printed. */
export const onPaper = () => document.documentElement.classList.contains("paper");

/** Pixels of canvases for each one of the page. */
export const sharpness = () => (onPaper() ? FINE : Math.min(devicePixelRatio || 1, 2));

/** Follow the browser: `redraw` draws everything anew, once for paper and once for the screen. */
export function follow(redraw) {
  for (const [event, is] of [["beforeprint", true], ["afterprint", false]]) {
    addEventListener(event, () => {
      document.documentElement.classList.toggle("paper", is);
      redraw();
    });
  }
}
