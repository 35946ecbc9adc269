"""Posters: a scene's first picture in its page, painted before any script has loaded."""

from __future__ import annotations

import base64
import hashlib
import html
from dataclasses import dataclass

from server.http.security_headers import EMBEDDABLE_POLICY

__all__ = ["Poster"]


@dataclass(frozen=True)
class Poster:
    """Picture of a scene from its first camera, for the page that opens at that camera."""

    address: str
    """URL relative to the page, percent-encoded for CSS."""

    shape: float
    """Width / height."""

    @property
    def preload(self) -> str:
        """Return the link element that makes browsers load the picture first."""
        return f'<link rel="preload" as="image" href="{html.escape(self.address)}" fetchpriority="high">'

    def style(self, selector: str) -> str:
        """Return the style of an element that fills its page, with the poster as background.

        The poster is framed like the first picture in `fitted` of web_client/src/camera/pinhole.ts, which replaces it.
        """
        height = f"min(max(100vh, {100 / self.shape:.4f}vw), 120vh, {120 / self.shape:.4f}vw)"
        return (
            f'{selector} {{ background: #000 url("{self.address}") center / auto {height} no-repeat; }}\n'
            f"@media (aspect-ratio < 1) {{ {selector} {{ background-size: cover; }} }}"
        )

    def painted_on(self, page: str) -> tuple[str, str]:
        """Return a built page with the poster, and its content security policy; unchanged if it has no body."""
        if "<body>" not in page or "</title>" not in page:
            return page, EMBEDDABLE_POLICY
        style = f"\n.poster {{ position: fixed; inset: 0; }}\n{self.style('.poster')}\n"
        digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
        page = page.replace("</title>", f"</title>\n{self.preload}\n<style>{style}</style>", 1)
        page = page.replace("<body>", '<body>\n<main class="player-host poster"></main>', 1)
        return page, EMBEDDABLE_POLICY.replace("style-src 'self'", f"style-src 'self' 'sha256-{digest}'")
