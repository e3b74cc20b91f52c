// The time that is shown: it plays, rests at the end and starts over, or stands where it is put.
"use strict";

const HOLD = 1.5; // how long the end is shown before the motion starts over, s
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

function makeClock(duration) {
  const listeners = [];
  let run = 0, speed = 1, playing = true, last = null;

  const clock = {
    duration,
    get t() { return Math.min(run, duration); },
    get playing() { return playing; },
    get speed() { return speed; },
    onChange(listener) { listeners.push(listener); },

    seek(t) {
      run = Math.min(Math.max(t, 0), duration);
      tell();
    },
    play() {
      if (run >= duration) run = 0;
      playing = true;
      last = null;
      tell();
    },
    pause() {
      playing = false;
      tell();
    },
    toggle() {
      if (playing) clock.pause(); else clock.play();
    },
    // Go a frame on; the motion stands still then.
    step(by) {
      playing = false;
      clock.seek(clock.t + by);
    },
    setSpeed(value) {
      speed = value;
      tell();
    },
    changeSpeed(by) {
      const i = SPEEDS.indexOf(speed) + by;
      if (i in SPEEDS) clock.setSpeed(SPEEDS[i]);
    },
    // Let time go on until `now`, in ms.
    tick(now) {
      const passed = last === null ? 0 : (now - last) / 1000;
      last = now;
      if (!playing || !passed) return;
      run += speed * passed;
      if (run > duration + HOLD * speed) run = 0;
      tell();
    },
  };

  function tell() {
    for (const listener of listeners) listener(clock.t);
  }
  return clock;
}
