// Numbers over time, as Python packs them.
"use strict";

// Return the numbers that are packed in base64.
function unpacked(text) {
  if (text === null || text === undefined) return null;
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

// Return the moment at or before t, by its number, and the share of the way to the next one.
function momentAt(moments, t) {
  let low = 0, high = moments.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (moments[middle] <= t) low = middle; else high = middle;
  }
  if (moments.length < 2) return [0, 0];
  const share = (t - moments[low]) / (moments[low + 1] - moments[low]);
  return [low, Math.min(Math.max(share, 0), 1)];
}

// Return the number of the moment nearest to t.
function nearestMoment(moments, t) {
  const [i, share] = momentAt(moments, t);
  return share < 0.5 ? i : Math.min(i + 1, moments.length - 1);
}

// Return a row of numbers between those of two moments.
function rowAt(values, width, [i, share]) {
  const row = new Array(width), next = share > 0 ? i + 1 : i;
  for (let k = 0; k < width; k++) {
    const from = values[i * width + k];
    row[k] = from + share * (values[next * width + k] - from);
  }
  return row;
}
