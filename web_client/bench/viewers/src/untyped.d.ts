declare module "@mkkellogg/gaussian-splats-3d" {
  export const LogLevel: { readonly None: number };
  export const SceneRevealMode: { readonly Instant: number };
  export class Viewer {
    constructor(options: Readonly<Record<string, unknown>>);
    readonly sortRunning: boolean;
    addSplatScene(url: string, options: Readonly<Record<string, unknown>>): Promise<void>;
    update(): void;
    render(): void;
  }
}
