"""Posters: the picture of a scene in its page itself, painted before any of the page's scripts has come."""

from __future__ import annotations

import base64
import hashlib
import html
from dataclasses import dataclass

from server.http.security_headers import EMBEDDABLE_POLICY

__all__ = ["Poster"]


@dataclass(frozen=True)
class Poster:
    """The picture of a scene from its first camera, for the page that opens on that camera."""

    address: str
    """Relative to the page, of characters that stand for themselves in CSS: percent-encoded."""

    shape: float
    """Its width by its height."""

    @property
    def preload(self) -> str:
        """The link that lets a browser ask for the picture before anything else."""
        return f'<link rel="preload" as="image" href="{html.escape(self.address)}" fetchpriority="high">'

    def style(self, selector: str) -> str:
        """Return the style of an element that fills its page, with the poster as its ground.

        As `fitted` in web_client/src/camera/pinhole.ts frames the first picture, which so takes the poster's place.
        """
        height = f"min(max(100vh, {100 / self.shape:.4f}vw), 120vh, {120 / self.shape:.4f}vw)"
        return (
            f'{selector} {{ background: #000 url("{self.address}") center / auto {height} no-repeat; }}\n'
            f"@media (aspect-ratio < 1) {{ {selector} {{ background-size: cover; }} }}"
        )

    def painted_on(self, page: str) -> tuple[str, str]:
        """Return a built page with the poster, and what browsers may do with that page; without a body, unchanged."""
        if "<body>" not in page or "</title>" not in page:
            return page, EMBEDDABLE_POLICY
        style = f"\n.poster {{ position: fixed; inset: 0; }}\n{self.style('.poster')}\n"
        digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
        page = page.replace("</title>", f"</title>\n{self.preload}\n<style>{style}</style>", 1)
        page = page.replace("<body>", '<body>\n<main class="player-host poster"></main>', 1)
        return page, EMBEDDABLE_POLICY.replace("style-src 'self'", f"style-src 'self' 'sha256-{digest}'")
