/**
 * The entry of all pages: below the server's root, the console is at `/`, `/new` and `/job/{job}`, the player at
 * `/view/{scene}`.
 */

import { pageAt } from "./console/page_address";
import { beginSiteAt, KEY_NEEDED, pathInSite, siteUrl } from "./protocol/http";
import "./ui/style.css";
import "./console/tokens.css";

addEventListener(KEY_NEEDED, async () => {
  const { showKeyPage } = await import("./console/key_page");
  if (!document.body.classList.contains("key-page")) showKeyPage(document.body);
});

const { url } = import.meta; // address of this script, one folder below the server's root
beginSiteAt(new URL("..", url).pathname);
const page = pageAt(pathInSite(location.pathname));

// Each page is a bundle of its own, so that the console does not load the player.
switch (page.kind) {
  case "view": {
    const { showViewPage } = await import("./console/view_page");
    showViewPage(document.body, page.scene);
    break;
  }
  case "job": {
    const { showJobPage } = await import("./console/job_page");
    showJobPage(document.body, page.job);
    break;
  }
  case "new": {
    const { showSubmitPage } = await import("./console/submit_page");
    showSubmitPage(document.body);
    break;
  }
  case "list": {
    const { showListPage } = await import("./console/list_page");
    showListPage(document.body);
    break;
  }
  case "unknown": {
    const { showNotFoundPage } = await import("./console/not_found_page");
    showNotFoundPage(document.body, siteUrl(""));
  }
}

// A page from the browser's back-forward cache has given up its connections and memory: start over.
addEventListener("pageshow", (event) => {
  if (event.persisted) location.reload();
});
