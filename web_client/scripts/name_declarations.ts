/** The last step of `npm run build:package`. */

import { nameFiles } from "../plugins/declarations.ts";

await nameFiles("dist/types");
