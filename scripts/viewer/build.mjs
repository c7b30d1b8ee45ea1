// Bundles src/viewer.js with three.js into one script that a report carries inside it:
//   cd scripts/viewer && npm ci && npm run build
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { copyFileSync, readFileSync, readdirSync, writeFileSync } from "node:fs";

const out = new URL("../../camgeom/report/assets/", import.meta.url).pathname;
// The banner names the sources by their digest, so that a test can tell a bundle that was not built again.
const source = new URL("src/", import.meta.url).pathname;
const digest = createHash("sha256");
for (const name of readdirSync(source).sort()) digest.update(readFileSync(source + name));
const version = JSON.parse(readFileSync(new URL("node_modules/three/package.json", import.meta.url), "utf8")).version;
const result = await build({
  entryPoints: [new URL("src/viewer.js", import.meta.url).pathname],
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome90", "firefox115", "safari16.4"],
  legalComments: "none",
  banner: { js: `/*! camgeom report viewer, MIT. Contains three.js ${version}, MIT: see viewer.LICENSE.txt. Sources sha256 ${digest.digest("hex")} */` },
  write: false,
});
const text = result.outputFiles[0].text.replaceAll("</script", "<\\/script");
writeFileSync(out + "viewer.js", text);
copyFileSync(new URL("node_modules/three/LICENSE", import.meta.url).pathname, out + "viewer.LICENSE.txt");
console.log(`viewer.js: ${text.length} bytes, three.js ${version}`);
