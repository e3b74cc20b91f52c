// Plots over time, above the timeline and as wide: the pointer reads values, a click goes to its time.
"use strict";

const INK = "#2b3642", SECOND_INK = "#8456a8";
const PAD = 3; // pixels above and below a curve

// Return what is plotted: curves of a motion with their colours, and how values are said.
function plotTracks(page, motions) {
  const n = page.jointNames.length, h = page.hands.length;
  const column = (values, width, k) => values.filter((_, i) => i % width === k);
  const tracks = [
    {
      id: "clearance", title: "clearance", unit: "m", coloured: true, zero: true,
      curves: motion => motion.clearance ? [{ values: unpacked(motion.clearance) }] : linksOnly(motion),
      said: (motion, i) => {
        const kind = motion.closest.obstacles || motion.closest.links;
        return kind ? kind.names[kind.pair[i]] : "";
      },
    },
    {
      id: "manipulability", title: "manipulability", unit: "", from: 0,
      curves: motion => [{ values: unpacked(motion.manipulability) }], said: () => "",
    },
    shares("speed", "joint speeds", "speed"),
    shares("acceleration", "accelerations", "acceleration"),
    {
      id: "hands", title: "hand speeds", unit: "m/s", from: 0,
      curves: motion => page.hands.map((hand, k) =>
        ({ values: column(unpacked(motion.handSpeed), h, k), colour: hand.colour, name: hand.name })),
      said: (motion, i, curves) => curves[largest(curves, i)].name,
    },
  ];
  function linksOnly(motion) {
    return motion.closest.links ? [{ values: unpacked(motion.closest.links.distance) }] : [];
  }
  function shares(id, title, key) {
    return {
      id, title, unit: "%", from: 0, line: 1, factor: 100,
      curves: motion => {
        const values = unpacked(motion[key]);
        return values ? page.jointNames.map((name, k) => ({ values: column(values, n, k), name, isThin: true })) : [];
      },
      said: (motion, i, curves) => curves[largest(curves, i)].name,
    };
  }
  return tracks
    .map(track => ({ ...track, motions: motions.map(motion => track.curves(motion)) }))
    .filter(track => track.motions.some(curves => curves.length));
}

// Return which of some curves has the largest value at a moment.
function largest(curves, i) {
  return curves.reduce((best, curve, k) => curve.values[i] > curves[best].values[i] ? k : best, 0);
}

function makePlots(page, clock) {
  const { THREE } = MeshCat, root = document.getElementById("plots"), motions = page.motions;
  const moments = motions.map(motion => unpacked(motion.t));
  const tracks = plotTracks(page, motions).map(track => {
    const row = document.createElement("div"), title = document.createElement("div");
    const canvas = document.createElement("canvas"), value = document.createElement("div");
    row.className = "plot";
    row.id = `plot-${track.id}`;
    title.className = "title";
    value.className = "value";
    title.textContent = track.title;
    row.append(title, canvas, value);
    root.append(row);
    return { ...track, row, canvas, value, range: rangeOf(track) };
  });
  let hovered = null;

  function rangeOf(track) {
    const values = track.motions.flatMap(curves => curves.flatMap(curve => [...curve.values]));
    let low = track.from === undefined ? Infinity : track.from, high = track.line || -Infinity;
    for (const value of values) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (track.zero) low = Math.min(low, 0);
    return [low, high > low ? high : low + 1];
  }

  function colourOf(clearance) {
    const scale = page.clearanceColours;
    if (clearance < 0) return page.penetrationColour;
    const next = scale.findIndex(([at]) => at > clearance);
    if (next < 0) return scale[scale.length - 1][1];
    const [[low, from], [high, to]] = [scale[next - 1], scale[next]];
    return `#${new THREE.Color(from).lerp(new THREE.Color(to), (clearance - low) / (high - low)).getHexString()}`;
  }

  function draw(track) {
    const { canvas, range: [low, high] } = track, ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const x = t => t / (clock.duration || 1) * width;
    const y = value => PAD + (high - value) / (high - low) * (height - 2 * PAD);
    const rule = (value, colour) => {
      pen.fillStyle = colour;
      pen.fillRect(0, Math.round(y(value)), width, 1);
    };
    pen.fillStyle = "#dde3e9";
    for (const t of motions[0].arrivals) pen.fillRect(Math.round(x(t)), 0, 1, height);
    if (track.zero) rule(0, "#e3b1b1");
    if (track.line) rule(track.line, "#e3b1b1");
    [...track.motions.keys()].reverse().forEach(number => {
      const curves = track.motions[number], t = moments[number];
      curves.forEach(curve => {
        pen.setLineDash(number ? [5, 3] : []);
        pen.lineWidth = curve.isThin ? 1 : 1.6;
        pen.globalAlpha = curve.isThin ? 0.28 : 1;
        pen.strokeStyle = number ? SECOND_INK : curve.colour || INK;
        if (track.coloured && !number) drawColoured(pen, t, curve.values, x, y);
        else {
          pen.beginPath();
          curve.values.forEach((value, i) => pen.lineTo(x(t[i]), y(value)));
          pen.stroke();
        }
      });
      if (!curves.some(curve => curve.isThin)) return;
      pen.globalAlpha = 1;
      pen.lineWidth = 1.6;
      pen.beginPath();
      t.forEach((at, i) => pen.lineTo(x(at), y(curves[largest(curves, i)].values[i])));
      pen.stroke();
    });
  }

  function drawColoured(pen, t, values, x, y) {
    pen.lineWidth = 2.2;
    for (let i = 1; i < t.length; i++) {
      pen.strokeStyle = colourOf((values[i - 1] + values[i]) / 2);
      pen.beginPath();
      pen.moveTo(x(t[i - 1]), y(values[i - 1]));
      pen.lineTo(x(t[i]), y(values[i]));
      pen.stroke();
    }
  }

  // Return what a track says of a moment: values as numbers, and in words.
  function read(track, t) {
    return motions.map((motion, number) => {
      const curves = track.motions[number], i = nearestMoment(moments[number], t);
      if (!curves.length) return { values: [], text: "\u2013", said: "" };
      const values = curves.map(curve => curve.values[i]), top = Math.max(...values);
      const shown = track.factor ? (track.factor * top).toFixed(0) : top.toFixed(top >= 100 ? 1 : 3);
      return { values, text: `${shown}${track.unit === "%" ? " %" : track.unit && ` ${track.unit}`}`, said: track.said(motion, i, curves) };
    });
  }

  function say() {
    const t = hovered === null ? clock.t : hovered;
    for (const track of tracks) {
      const parts = read(track, t).flatMap(({ text, said }, number) => {
        const value = Object.assign(document.createElement("b"), { textContent: text, className: `of${number}` });
        const name = Object.assign(document.createElement("span"), { textContent: said, title: said });
        return motions.length > 1 ? [value] : [value, name];
      });
      track.value.replaceChildren(...parts);
    }
    root.style.setProperty("--at", clock.t / (clock.duration || 1));
    root.style.setProperty("--hover", hovered === null ? -1 : hovered / (clock.duration || 1));
    root.classList.toggle("hovered", hovered !== null);
  }

  const cursor = Object.assign(document.createElement("i"), { className: "cursor" });
  const hover = Object.assign(document.createElement("i"), { className: "cursor hover" });
  root.append(cursor, hover);
  const timeOf = event => {
    const box = tracks[0].canvas.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * clock.duration;
  };
  root.addEventListener("pointermove", event => {
    const box = tracks[0].canvas.getBoundingClientRect();
    hovered = event.clientX >= box.left && event.clientX <= box.right ? timeOf(event) : null;
    if (event.buttons && hovered !== null) clock.seek(hovered);
    say();
  });
  root.addEventListener("pointerleave", () => {
    hovered = null;
    say();
  });
  root.addEventListener("pointerdown", event => {
    clock.pause();
    clock.seek(timeOf(event));
  });
  clock.onChange(say);
  const resized = new ResizeObserver(() => tracks.forEach(draw));
  resized.observe(root);

  return {
    read: (id, t) => read(tracks.find(track => track.id === id), t),
  };
}
