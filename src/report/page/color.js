// Colours. The map of errors runs from blue to yellow with an even step in lightness, as cividis does (Nuñez, Anderson and Renslow 2018), so that
// it reads the same with any colour vision and in print. It is a straight line in OKLab (B. Ottosson 2020).

function fromOklab(lightness, a, b) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  const encoded = linear.map(c => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  return encoded.map(c => Math.round(255 * Math.min(1, Math.max(0, c))));
}

const STEPS = 256;

/** 256 colours from small to large, of which the large ones stand out against the page. */
function errorColors() {
  const dark = isDark();
  const [from, to] = dark ? [0.42, 0.94] : [0.84, 0.26];
  const blue = [-0.02, -0.11], yellow = [-0.01, 0.15];
  const colors = new Uint8Array(4 * STEPS);
  for (let k = 0; k < STEPS; k++) {
    const t = k / (STEPS - 1), y = dark ? t : 1 - t;
    const mix = c => blue[c] + (yellow[c] - blue[c]) * y;
    colors.set([...fromOklab(from + (to - from) * t, mix(0), mix(1)), 255], 4 * k);
  }
  return colors;
}

function isDark() {
  return document.documentElement.dataset.theme === "dark";
}

/** Colours of runs, axes and lines: those of Okabe and Ito (2008), which differ with any colour vision. */
function lineColor(index) {
  const colors = isDark()
    ? ["#e69f00", "#56b4e9", "#2fbf8f", "#cc79a7", "#f0e442", "#ff7f50", "#9ab8ff", "#e6e9ed"]
    : ["#c8550a", "#0072b2", "#00795a", "#a8518a", "#8a7a00", "#b3261e", "#4a5568", "#111111"];
  return colors[index % colors.length];
}

function rgb(hex) {
  return [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16) / 255);
}
