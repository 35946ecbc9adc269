/** The page: `/` lists scenes and jobs, `/view/{scene}` plays a scene, and nothing is at any other address. */

import { pageAt } from "./ui/page_address";
import "./ui/style.css";

const page = pageAt(location.pathname);

// Each page is a bundle of its own, so that the list does not load the player.
if (page.kind === "view") {
  const { showViewPage } = await import("./ui/view_page");
  showViewPage(document.body, page.scene);
} else if (page.kind === "unknown") {
  const { showNotFoundPage } = await import("./ui/not_found_page");
  showNotFoundPage(document.body);
} else {
  const { showListPage } = await import("./ui/list_page");
  showListPage(document.body);
}

// A page that comes back from the browser's cache has given its connections and memory back: begin anew.
addEventListener("pageshow", (event) => {
  if (event.persisted) location.reload();
});
