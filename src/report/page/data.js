// The numbers of the page.

function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const packed = atob(text);
  const bytes = new Uint8Array(packed.length);
  for (let k = 0; k < packed.length; k++) bytes[k] = packed.charCodeAt(k);
  return bytes;
}

/** The numbers of a column; NaN where there is no value. The arrays are little-endian, as are the machines that show pages. */
function column(of) {
  if (!of) return null;
  if (of.decoded) return of.decoded;
  const bytes = bytesOf(of.data);
  const types = { i16: Int16Array, u8: Uint8Array, u32: Uint32Array, f32: Float32Array };
  const stored = new types[of.kind](bytes.buffer, 0, of.length);
  let values = stored;
  if (of.kind === "i16") {
    values = new Float32Array(of.length);
    for (let k = 0; k < of.length; k++) values[k] = stored[k] === -32768 ? NaN : of.offset + of.scale * stored[k];
  }
  Object.defineProperty(of, "decoded", { value: values });
  return values;
}

/** The same for uPlot: plain numbers, null where there is no value or, on a logarithmic scale, none above zero. */
function plain(values, positive) {
  const out = new Array(values.length);
  for (let k = 0; k < values.length; k++) {
    const value = values[k];
    out[k] = Number.isFinite(value) && (!positive || value > 0) ? value : null;
  }
  return out;
}

/** The page's data with every column as plain numbers. */
function readable(value) {
  if (Array.isArray(value)) return value.map(readable);
  if (!value || typeof value !== "object") return value;
  if (typeof value.data === "string" && typeof value.kind === "string") return plain(column(value));
  return Object.fromEntries(Object.entries(value).map(([key, entry]) => [key, readable(entry)]));
}
