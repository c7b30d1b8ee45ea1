// Reads the buffers that camgeom/report/scene.py writes: base64, gzip, byte planes, little-endian words.

async function bytes(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function words(text, Type) {
  const planes = await bytes(text);
  const size = Type.BYTES_PER_ELEMENT;
  const count = planes.length / size;
  const joined = new Uint8Array(planes.length);
  for (let b = 0; b < size; b++) for (let i = 0; i < count; i++) joined[i * size + b] = planes[b * count + i];
  return new Type(joined.buffer);
}

// Undoes the differences of three columns (x, y, z or the corners of a triangle); typed arrays wrap as numpy does.
function rows(columns, Type) {
  const n = columns.length / 3;
  const out = new Type(columns.length);
  const sum = new Type(1);
  for (let c = 0; c < 3; c++) {
    sum[0] = 0;
    for (let i = 0; i < n; i++) {
      sum[0] += columns[c * n + i];
      out[3 * i + c] = sum[0];
    }
  }
  return out;
}

export async function unpackScene(data) {
  const bodies = await Promise.all(data.bodies.map(unpackBody));
  const readouts = await Promise.all(
    data.readouts.map(async (r) => ({ ...r, values: await words(r.values, Float32Array) })),
  );
  return { ...data, angles: await words(data.angles, Float32Array), bodies, readouts };
}

async function unpackBody(body) {
  const codes = rows(await words(body.vertices, Uint16Array), Uint16Array);
  const vertices = new Float32Array(codes.length);
  for (let i = 0; i < codes.length; i++) vertices[i] = body.low[i % 3] + (codes[i] / 65535) * body.size[i % 3];
  const fields = {};
  for (const key of Object.keys(body.fields)) fields[key] = await words(body.fields[key], Uint16Array);
  return {
    ...body,
    vertices,
    faces: rows(await words(body.faces, Uint32Array), Uint32Array),
    group: await words(body.group, Uint8Array),
    poses: body.poses && (await words(body.poses, Float32Array)),
    fields,
  };
}
