// A mesh for display: corners with normals that are smooth inside a named face and sharp at its edges and creases.
import { BufferAttribute, BufferGeometry } from "three";

const CREASE = Math.cos((32 * Math.PI) / 180);
const SLENDER = 5e-4; // area over the square of the longest side: the normal of such a face is rounding

export function displayGeometry({ vertices, faces, group }) {
  const count = faces.length;
  const normals = faceNormals(vertices, faces);
  const { first, around } = cornersAround(vertices.length / 3, faces);
  const position = new Float32Array(3 * count);
  const normal = new Float32Array(3 * count);
  for (let corner = 0; corner < count; corner++) {
    const vertex = faces[corner];
    const face = (corner / 3) | 0;
    position.set(vertices.subarray(3 * vertex, 3 * vertex + 3), 3 * corner);
    let x = 0, y = 0, z = 0;
    for (let k = first[vertex]; k < first[vertex + 1]; k++) {
      const other = around[k];
      if (group[other] !== group[face] || cosine(normals, face, other) < CREASE) continue;
      x += normals[4 * other] * normals[4 * other + 3];
      y += normals[4 * other + 1] * normals[4 * other + 3];
      z += normals[4 * other + 2] * normals[4 * other + 3];
    }
    const length = Math.hypot(x, y, z) || 1;
    normal[3 * corner] = x / length;
    normal[3 * corner + 1] = y / length;
    normal[3 * corner + 2] = z / length;
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(position, 3));
  geometry.setAttribute("normal", new BufferAttribute(normal, 3));
  geometry.setAttribute("uv", new BufferAttribute(new Float32Array(2 * count), 2));
  return { geometry, edges: edgeGeometry(vertices, faces, group, normals) };
}

// Writes a field (16-bit codes per vertex, 65535 for none) into the texture coordinates; a face with a bare corner, or of a
// group that does not take the colour, stays plain.
export function paint(geometry, { faces, group, groups }, codes, wanted) {
  const uv = geometry.getAttribute("uv");
  const takes = groups.map((name) => wanted.length === 0 || wanted.includes(name));
  for (let face = 0; face < faces.length / 3; face++) {
    const own = [0, 1, 2].map((k) => (codes ? codes[faces[3 * face + k]] : 65535));
    const plain = !takes[group[face]] || own.includes(65535);
    own.forEach((code, k) => {
      uv.array[2 * (3 * face + k)] = plain ? 0.5 : (0.5 + (255 * code) / 65534) / 256;
      uv.array[2 * (3 * face + k) + 1] = plain ? 0.25 : 0.75;
    });
  }
  uv.needsUpdate = true;
}

// Unit normal and area of each triangle, four numbers a face.
function faceNormals(vertices, faces) {
  const out = new Float32Array((4 * faces.length) / 3);
  for (let f = 0; f < faces.length / 3; f++) {
    const [a, b, c] = [3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]];
    const ux = vertices[b] - vertices[a], uy = vertices[b + 1] - vertices[a + 1], uz = vertices[b + 2] - vertices[a + 2];
    const vx = vertices[c] - vertices[a], vy = vertices[c + 1] - vertices[a + 1], vz = vertices[c + 2] - vertices[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const length = Math.hypot(x, y, z);
    out.set([x / (length || 1), y / (length || 1), z / (length || 1), length / 2], 4 * f);
  }
  return out;
}

function slender(vertices, faces, normals, f) {
  let longest = 0;
  for (let k = 0; k < 3; k++) {
    const a = 3 * faces[3 * f + k], b = 3 * faces[3 * f + ((k + 1) % 3)];
    longest = Math.max(longest, (vertices[a] - vertices[b]) ** 2 + (vertices[a + 1] - vertices[b + 1]) ** 2 + (vertices[a + 2] - vertices[b + 2]) ** 2);
  }
  return normals[4 * f + 3] < SLENDER * longest;
}

function cosine(normals, a, b) {
  return normals[4 * a] * normals[4 * b] + normals[4 * a + 1] * normals[4 * b + 1] + normals[4 * a + 2] * normals[4 * b + 2];
}

function cornersAround(count, faces) {
  const first = new Uint32Array(count + 1);
  for (const vertex of faces) first[vertex + 1]++;
  for (let v = 0; v < count; v++) first[v + 1] += first[v];
  const next = first.slice();
  const around = new Uint32Array(faces.length);
  for (let corner = 0; corner < faces.length; corner++) around[next[faces[corner]]++] = (corner / 3) | 0;
  return { first, around };
}

// Lines where two named faces meet at an angle, or the surface creases.
function edgeGeometry(vertices, faces, group, normals) {
  const seen = new Map();
  const points = [];
  const total = vertices.length / 3;
  for (let corner = 0; corner < faces.length; corner++) {
    const face = (corner / 3) | 0;
    const a = faces[corner], b = faces[corner % 3 === 2 ? corner - 2 : corner + 1];
    const key = Math.min(a, b) * total + Math.max(a, b);
    const other = seen.get(key);
    if (other === undefined) {
      seen.set(key, face);
      continue;
    }
    const apart = group[face] !== group[other];
    const unsure = slender(vertices, faces, normals, face) || slender(vertices, faces, normals, other);
    const turn = cosine(normals, face, other);
    if (unsure ? apart : turn < CREASE || (apart && turn < 0.985)) {
      points.push(...vertices.subarray(3 * a, 3 * a + 3), ...vertices.subarray(3 * b, 3 * b + 3));
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}
