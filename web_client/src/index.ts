/** `@hgs/player`: a player of moving scenes of Gaussian splats for any page. See docs/embedding.md. */

export type { Vec3 } from "./camera/vector";
export type { Manifest, ManifestCamera } from "./codec/types";
export { HgsPlayer } from "./player/hgs_player";
export type {
  Beginning,
  HgsPlayerEvent,
  HgsPlayerEvents,
  HgsPlayerListening,
  HgsPlayerOptions,
  PlayerProblem,
} from "./player/hgs_player_events";
export type { PlayerCamera } from "./player/player_camera";
export type { PlayerStats } from "./player/player_types";
export type { Viewing, ViewpointOptions } from "./player/viewpoint";
export { QUALITIES, type Quality } from "./renderer/fineness";
export type { Pixels } from "./renderer/shot";
export { openSource } from "./source/open_source";
export type {
  OpenSource,
  Playhead,
  SceneSource,
  SourceEvents,
  SourceFailure,
  SourceState,
} from "./source/scene_source";
export { type CreatePlayerOptions, createPlayer } from "./ui/create_player";
export type { WholePage } from "./ui/player_view_options";
export type { SharedView } from "./ui/shared_view";
