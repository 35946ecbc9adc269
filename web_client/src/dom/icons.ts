/** Icon paths on a 24 x 24 grid. */

export const PLAY = "M8 5.5v13l11-6.5z";
export const PAUSE = "M7 5.5h3.6v13H7zM13.4 5.5H17v13h-3.6z";
export const REPLAY = "M12 5V2L7.5 6 12 10V7a5.5 5.5 0 1 1-5.5 5.5h-2A7.5 7.5 0 1 0 12 5z";
export const BACK = "M14.5 5 7.5 12l7 7 1.5-1.5L10.5 12 16 6.5z";
export const FULLSCREEN = "M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z";
export const CLOSE = "M6.4 5 12 10.6 17.6 5 19 6.4 13.4 12 19 17.6 17.6 19 12 13.4 6.4 19 5 17.6 10.6 12 5 6.4z";
export const PLUS = "M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z";
export const MORE =
  "M12 5a1.8 1.8 0 1 1 0 3.6A1.8 1.8 0 0 1 12 5zm0 5.2a1.8 1.8 0 1 1 0 3.6 1.8 1.8 0 0 1 0-3.6zm0 5.2a1.8 1.8 0 1 1 0 3.6 1.8 1.8 0 0 1 0-3.6z";
export const SETTINGS = "M3 6h9v2H3zm14 0h4v2h-4zm-3-2h2v6h-2zM3 16h4v2H3zm9 0h9v2h-9zm-3-2h2v6H9z";
