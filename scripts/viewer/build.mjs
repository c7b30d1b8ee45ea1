// Bundles src/viewer.js with three.js into one script that a report carries inside it:
//   cd scripts/viewer && npm ci && npm run build
import { build } from "esbuild";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";

const out = new URL("../../camgeom/report/assets/", import.meta.url).pathname;
const result = await build({
  entryPoints: [new URL("src/viewer.js", import.meta.url).pathname],
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome90", "firefox115", "safari16.4"],
  legalComments: "none",
  banner: { js: "/*! camgeom report viewer, MIT. Contains three.js, MIT: see viewer.LICENSE.txt */" },
  write: false,
});
const text = result.outputFiles[0].text.replaceAll("</script", "<\\/script");
writeFileSync(out + "viewer.js", text);
copyFileSync(new URL("node_modules/three/LICENSE", import.meta.url).pathname, out + "viewer.LICENSE.txt");
const version = JSON.parse(readFileSync(new URL("node_modules/three/package.json", import.meta.url), "utf8")).version;
console.log(`viewer.js: ${text.length} bytes, three.js ${version}`);
