// Where the joints of a robot are: forward kinematics.
"use strict";

// Return the product of two placements, matrices (4, 4) by columns.
function times(a, b) {
  const c = new Array(16).fill(0);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

// Return the motion of a joint by `at` m along, or rad about, its axis.
function motion(joint, at) {
  const [x, y, z] = joint.axis;
  if (joint.kind === "prismatic") return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x * at, y * at, z * at, 1];
  const s = Math.sin(at), c = Math.cos(at), d = 1 - c;
  return [
    c + d * x * x, d * x * y + s * z, d * x * z - s * y, 0,
    d * x * y - s * z, c + d * y * y, d * y * z + s * x, 0,
    d * x * z + s * y, d * y * z - s * x, c + d * z * z, 0,
    0, 0, 0, 1,
  ];
}

// Return where all joints are in a configuration, followers with their leaders.
function placements(joints, q) {
  const found = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]];
  for (const joint of joints) {
    const at = joint.follows.reduce((sum, [i, factor]) => sum + factor * q[i], joint.offset);
    found.push(times(times(found[joint.parent], joint.placement), motion(joint, at)));
  }
  return found;
}
