/** The page: `/view/{scene}` plays a scene, every other address lists scenes and jobs. */

import "./ui/style.css";

const scene = /^\/view\/([A-Za-z0-9_-][A-Za-z0-9._-]{0,63})\/?$/.exec(location.pathname);

// Each page is a bundle of its own, so that the list does not load the player.
if (scene) {
  const { showViewPage } = await import("./ui/view_page");
  showViewPage(document.body, scene[1]);
} else {
  const { showListPage } = await import("./ui/list_page");
  showListPage(document.body);
}

// A page that comes back from the browser's cache has given its connections and memory back: begin anew.
addEventListener("pageshow", (event) => {
  if (event.persisted) location.reload();
});
