// The timeline: play, pause, step, speed, and a track to scrub along, with marks where targets are reached.
"use strict";

const FRAME = 1 / 30; // s

function makeTimeline(page, clock) {
  const find = id => document.getElementById(id), scrubber = find("scrubber"), track = find("track");
  const arrivals = page.motions[0].arrivals;

  page.motions.forEach((motion, number) => motion.arrivals.forEach((t, i) => {
    const of = page.motions.length > 1 ? `${motion.name}: ` : "";
    const mark = Object.assign(document.createElement("i"), {
      className: `mark-at of${number}`, title: `${of}target ${i + 1}, reached at ${t.toFixed(2)} s`,
    });
    mark.style.left = `${100 * t / (clock.duration || 1)}%`;
    mark.textContent = motion.arrivals.length > 1 ? i + 1 : "";
    track.append(mark);
  }));
  const marks = [0, ...page.motions.flatMap(motion => motion.arrivals), clock.duration].sort((a, b) => a - b);

  // Return the segment at a time: 1 on the way to the first target.
  const segment = t => Math.min(arrivals.filter(arrival => arrival < t - 1e-9).length + 1, page.steps);

  function say() {
    const { t, duration } = clock;
    scrubber.style.setProperty("--at", t / (duration || 1));
    scrubber.setAttribute("aria-valuemax", duration);
    scrubber.setAttribute("aria-valuenow", t.toFixed(3));
    const part = page.steps > 1 ? `target ${segment(t)} of ${page.steps}` : "";
    find("time").replaceChildren(
      Object.assign(document.createElement("b"), { textContent: t.toFixed(2) }),
      ` / ${duration.toFixed(2)} s`,
      Object.assign(document.createElement("span"), { textContent: part }),
    );
    find("play").classList.toggle("playing", clock.playing);
    find("speed").textContent = `${clock.speed}\u00d7`;
  }

  function scrub(event) {
    const box = track.getBoundingClientRect();
    clock.seek((event.clientX - box.left) / box.width * clock.duration);
  }
  scrubber.addEventListener("pointerdown", event => {
    scrubber.setPointerCapture(event.pointerId);
    clock.pause();
    scrub(event);
  });
  scrubber.addEventListener("pointermove", event => {
    if (event.buttons) scrub(event);
  });
  find("play").addEventListener("click", clock.toggle);
  find("back").addEventListener("click", () => clock.step(-FRAME));
  find("forward").addEventListener("click", () => clock.step(FRAME));
  find("speed").addEventListener("click", () =>
    clock.setSpeed(SPEEDS[(SPEEDS.indexOf(clock.speed) + 1) % SPEEDS.length]));
  clock.onChange(say);
  say();

  return {
    // Go to the next or the previous mark.
    jump(by) {
      const t = clock.t;
      const to = by > 0 ? marks.find(mark => mark > t + 1e-3) : marks.filter(mark => mark < t - 1e-3).pop();
      clock.pause();
      if (to !== undefined) clock.seek(to);
    },
  };
}
