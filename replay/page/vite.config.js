// Builds the page as one HTML file with script and style inside, which the program embeds and completes with data.
import { createHash } from "node:crypto";

import { defineConfig } from "vite";

/** How a Content-Security-Policy names an inline script or style. */
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** Puts the script and the style into the HTML file, and their hashes into its policy, so that nothing else may run. */
function inline() {
  return {
    name: "underbrush-inline",
    enforce: "post",
    generateBundle(_options, bundle) {
      const html = Object.values(bundle).find((file) => file.fileName === "index.html");
      let text = html.source;
      for (const file of Object.values(bundle)) {
        const name = file.fileName.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
        if (file.type === "chunk") {
          // A closing tag in a string of the script would end it.
          const code = file.code.replace(/<\/(script)/gi, "<\\/$1").replace(/<!--/g, "<\\!--").trimEnd();
          // After the body and before the data, so that a file that was cut off in either still shows a message. Modules run
          // when all is read.
          const tag = new RegExp(`<script[^>]*src="[^"]*${name}"[^>]*></script>`);
          const script = `<script type="module">${code}</script>\n<!--underbrush-data-->`;
          text = text.replace(tag, "").replace("<!--underbrush-data-->", () => script).replace("HASH-OF-SCRIPT", hash(code));
        } else if (file.fileName.endsWith(".css")) {
          const style = file.source.trimEnd();
          const tag = new RegExp(`<link[^>]*href="[^"]*${name}"[^>]*>`);
          text = text.replace(tag, () => `<style>${style}</style>`).replace("HASH-OF-STYLE", hash(style));
        } else {
          continue;
        }
        delete bundle[file.fileName];
      }
      if (/\s(src|href)="(?!#|data:)/.test(text.replace(/<script[\s\S]*?<\/script>|<style[\s\S]*?<\/style>/g, ""))) {
        throw new Error("the page still refers to another file");
      }
      if (text.split("<!--underbrush-data-->").length !== 2) {
        throw new Error("the page must have exactly one place for data");
      }
      if (text.includes("HASH-OF-")) throw new Error("the page has no inline script or no inline style");
      html.source = text;
    },
  };
}

export default defineConfig({
  plugins: [inline()],
  build: { target: "es2022", modulePreload: false, assetsInlineLimit: 1e6, cssCodeSplit: false, chunkSizeWarningLimit: 2000 },
});
