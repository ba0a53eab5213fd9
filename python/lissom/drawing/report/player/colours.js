// Colours: of layers, along rods by what the reader picks, and of the page.

/** [red, green, blue] from 0 to 1 of "#rrggbb". */
export const parse = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);

/** A colour between the stops of a scale. */
export function sample(stops, at) {
  const x = Math.min(Math.max(at, 0), 1);
  const k = Math.max(stops.findIndex(([stop]) => stop >= x), 1);
  const [[a, first], [b, second]] = [stops[k - 1], stops[k]];
  const part = (x - a) / (b - a || 1);
  const [p, q] = [parse(first), parse(second)];
  return p.map((value, i) => value + (q[i] - value) * part);
}

/** What rods can be coloured by, with the range of each. */
export function ways(things) {
  const tubes = things.filter(({ kind }) => kind === "tube");
  const found = [{ name: "position along the rod" }];
  const segments = Math.max(0, ...tubes.map(({ segment }) => Math.max(...segment)));
  if (segments > 0) found.push({ name: "segment", segments: segments + 1 });
  for (const name of new Set(tubes.flatMap(({ quantities }) => Object.keys(quantities)))) {
    let [low, high] = [Infinity, -Infinity];
    for (const { quantities } of tubes) {
      for (const value of quantities[name]?.values ?? []) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (high > low) found.push({ name, low, high });
  }
  return found;
}

/** A colour of the page by the name of its custom property. */
export const ofPage = (element, name) => getComputedStyle(element).getPropertyValue(name).trim();
