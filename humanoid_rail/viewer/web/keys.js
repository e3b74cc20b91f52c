// Keys, and the help that lists them; what they turn on and off can be clicked there too.
"use strict";

// Listen to keys: `views` has for each name what turns it on or off, and whether it is on at the beginning.
function makeKeys(clock, timeline, views) {
  const help = document.getElementById("help"), opener = document.getElementById("help-button");
  const buttons = Object.fromEntries([...help.querySelectorAll("[data-view]")].map(each => [each.dataset.view, each]));
  const byKey = Object.fromEntries(Object.entries(buttons).map(([name, each]) =>
    [each.querySelector("kbd").textContent.toLowerCase(), name]));

  function set(name, value) {
    views[name].isOn = value;
    views[name].turn(value);
    buttons[name].setAttribute("aria-pressed", value);
  }
  function toggle(name) {
    set(name, !views[name].isOn);
  }
  function toggleHelp(value = help.hidden) {
    help.hidden = !value;
    opener.classList.toggle("open", value);
  }
  for (const name of Object.keys(views)) {
    set(name, views[name].isOn);
    buttons[name].addEventListener("click", () => toggle(name));
  }
  opener.addEventListener("click", () => toggleHelp());

  const moves = {
    " ": clock.toggle,
    ArrowLeft: event => event.shiftKey ? timeline.jump(-1) : clock.step(-FRAME),
    ArrowRight: event => event.shiftKey ? timeline.jump(1) : clock.step(FRAME),
    Home: () => { clock.pause(); clock.seek(0); },
    End: () => { clock.pause(); clock.seek(clock.duration); },
    "+": () => clock.changeSpeed(1),
    "=": () => clock.changeSpeed(1),
    "-": () => clock.changeSpeed(-1),
    "?": () => toggleHelp(),
    Escape: () => toggleHelp(false),
  };
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const move = moves[event.key], name = byKey[event.key.toLowerCase()];
    if (!move && !name) return;
    event.preventDefault();
    if (move) move(event); else toggle(name);
  });
}
