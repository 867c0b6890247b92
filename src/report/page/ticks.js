// Round numbers on axes.

/** 1, 2 or 5 times a power of ten, not above `value`. */
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].map(digit => digit * power).find(rounded => rounded <= value * (1 + 1e-9)) || power;
}

/** 1, 2 or 5 times a power of ten, not below `value`. */
function roundAbove(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map(digit => digit * power).find(rounded => rounded >= value * (1 - 1e-9));
}

/** Round values from `low` to `high`, some `wanted` of them, and the decimals that they need. */
function ticks(low, high, wanted) {
  const step = roundAbove((high - low) / Math.max(1, wanted));
  const values = [];
  for (let k = Math.ceil(low / step); k * step <= high && values.length < 200; k++) values.push(k * step);
  return { values, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}
