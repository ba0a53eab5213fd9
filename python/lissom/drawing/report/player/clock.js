// The time that is shown. It runs with the wall's clock: a slow machine shows fewer pictures, not a slower motion.

export class Clock {
  constructor() {
    this.start = 0;
    this.end = 0;
    this.time = 0;
    /** Units of the clock a second. */
    this.speed = 1;
    this.loops = true;
    this.plays = false;
    this.listeners = new Set();
  }

  cover(start, end, time) {
    Object.assign(this, { start, end });
    this.seek(time);
  }

  /** Calls `listener` now and whenever the time, or whether it runs, has changed. */
  listen(listener) {
    this.listeners.add(listener);
    listener(this);
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.tell();
  }

  toggle() {
    if (this.plays) this.pause();
    else this.play();
  }

  play() {
    if (this.plays || this.end <= this.start) return;
    if (this.time >= this.end) this.time = this.start;
    this.plays = true;
    let before = performance.now();
    const tick = (now) => {
      if (!this.plays) return;
      // A page in the background gets no ticks; it goes on where it was.
      const elapsed = Math.min(Math.max(now - before, 0) / 1000, 1);
      before = now;
      let time = this.time + elapsed * this.speed;
      if (time > this.end) {
        if (this.loops) time = this.start + ((time - this.start) % (this.end - this.start));
        else this.plays = false;
      }
      this.seek(time);
      if (this.plays) requestAnimationFrame(tick);
    };
    this.tell();
    requestAnimationFrame(tick);
  }

  pause() {
    this.plays = false;
    this.tell();
  }
}

const clocks = new Map();

/** The clock of a name: one for all who ask for it. */
export function clock(name) {
  if (!clocks.has(name)) clocks.set(name, new Clock());
  return clocks.get(name);
}
