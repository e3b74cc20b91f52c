// How far convex bodies are from each other, by the algorithm of Gilbert, Johnson and Keerthi.
// A body is the hull of `points`, or of discs of radius `disc` around them across `axis`, made thicker by `radius`.
"use strict";

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

// Return the point of a body, without its thickness, that is farthest in a direction.
function support(body, direction) {
  let best = body.points[0], most = -Infinity;
  for (const point of body.points) {
    const far = dot(point, direction);
    if (far > most) [most, best] = [far, point];
  }
  if (!body.disc) return best;
  const along = dot(direction, body.axis);
  const across = direction.map((x, i) => x - along * body.axis[i]), length = Math.hypot(...across);
  return length < 1e-12 ? best : best.map((x, i) => x + body.disc * across[i] / length);
}

// Return the weights of some points, by which the point nearest to the origin of all that they span is made of them;
// null if they span less than they could.
function weights(points) {
  const base = points[0], edges = points.slice(1).map(point => minus(point, base)), n = edges.length;
  const rows = edges.map(a => [...edges.map(b => dot(a, b)), -dot(a, base)]);
  for (let k = 0; k < n; k++) {
    let pivot = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[pivot][k])) pivot = i;
    [rows[k], rows[pivot]] = [rows[pivot], rows[k]];
    if (Math.abs(rows[k][k]) < 1e-18) return null;
    for (let i = 0; i < n; i++) {
      if (i === k) continue;
      const factor = rows[i][k] / rows[k][k];
      for (let j = k; j <= n; j++) rows[i][j] -= factor * rows[k][j];
    }
  }
  const rest = rows.map((row, k) => row[n] / row[k]);
  return [1 - rest.reduce((sum, x) => sum + x, 0), ...rest];
}

// Return the point of a simplex that is nearest to the origin, and the corners that it is between.
function nearest(simplex) {
  let best = null, least = Infinity;
  for (let chosen = 1; chosen < 1 << simplex.length; chosen++) {
    const corners = simplex.filter((_, i) => chosen >> i & 1), parts = weights(corners);
    if (parts === null || parts.some(part => part < 0)) continue;
    const point = [0, 1, 2].map(i => corners.reduce((sum, corner, k) => sum + parts[k] * corner[i], 0));
    const length = dot(point, point);
    if (length < least) [least, best] = [length, { point, corners }];
  }
  return best;
}

// Return the distance of two bodies in m: 0 or less where they touch, but not how deep.
function convexDistance(first, second) {
  const thick = first.radius + second.radius;
  let v = minus(first.points[0], second.points[0]), simplex = [];
  for (let step = 0; step < 100; step++) {
    const length = dot(v, v);
    if (length < 1e-14) return -thick;
    const w = minus(support(first, v.map(x => -x)), support(second, v));
    if (length - dot(v, w) <= 1e-6 * length) break;
    const found = nearest([...simplex, w]);
    if (found === null || found.corners.length === 4) return -thick;
    if (simplex.length && dot(found.point, found.point) >= length) break;
    [v, simplex] = [found.point, found.corners];
  }
  return Math.sqrt(dot(v, v)) - thick;
}
