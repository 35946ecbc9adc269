BEGIN TRANSACTION;
CREATE TABLE application_versions (
    version_id TEXT NOT NULL PRIMARY KEY,
    version_name TEXT NOT NULL UNIQUE,
    version_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
, "application_name" TEXT DEFAULT NULL);
CREATE TABLE dbos_migrations (version INTEGER NOT NULL PRIMARY KEY);
INSERT INTO "dbos_migrations" VALUES(125);
CREATE TABLE hgs_home (
	id VARCHAR(36) NOT NULL, 
	PRIMARY KEY (id)
);
INSERT INTO "hgs_home" VALUES('7cd5d337-f248-485f-8d96-7e548082aeb1');
CREATE TABLE hgs_job (
	id VARCHAR(64) NOT NULL, 
	title TEXT NOT NULL, 
	capture TEXT NOT NULL, 
	config JSON NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	attempt INTEGER NOT NULL, 
	epoch INTEGER DEFAULT '0' NOT NULL, 
	stage VARCHAR(32) NOT NULL, 
	done BIGINT NOT NULL, 
	total BIGINT NOT NULL, 
	figures JSON NOT NULL, 
	error TEXT NOT NULL, 
	scene_id VARCHAR(64) NOT NULL, 
	waiting TEXT DEFAULT '' NOT NULL, 
	cause VARCHAR(16) DEFAULT '' NOT NULL, 
	created FLOAT NOT NULL, 
	updated FLOAT NOT NULL, 
	labels JSON DEFAULT '[]' NOT NULL, 
	priority INTEGER DEFAULT '0' NOT NULL, 
	time_limit FLOAT DEFAULT '0' NOT NULL, 
	stage_ends FLOAT DEFAULT '0' NOT NULL, 
	webhook TEXT DEFAULT '' NOT NULL, 
	audio TEXT DEFAULT '' NOT NULL, 
	request_key VARCHAR(255), 
	request_digest VARCHAR(64) DEFAULT '' NOT NULL, 
	PRIMARY KEY (id)
);
INSERT INTO "hgs_job" VALUES('done-ab442600','Done','{HOME}/captures/room','{"preset": "standard", "seed": 0, "capture": {"hold_out": [], "downscale": 1, "downscale_cameras": [], "frame_memory_mib": 1536, "trust_poses": false, "sync": "auto"}, "points": {"static": 30000, "dynamic": 8000, "interval": 0.3333333333333333, "stereo": true, "continued": true, "discs": false}, "train": {"iterations": 3, "stages": "together", "motion_order": 3, "segment_frames": 150, "antialiased": true, "elongation": 20.0, "colour_correction": true, "lens_falloff": true, "dssim": 0.2, "coarse_until": 0.25, "moving_steps": 3.0, "settle_from": 0.6, "settled": 0.02, "hold_from": 0.85, "held_statics": 3.0, "average_from": 0.9, "steps_by_life": true, "checkpoint_every": 500, "backend": "auto", "density": {"method": "gradient", "max_static": 80000, "max_dynamic": 15000, "start": 0.04, "end": 0.6, "every": 50, "grow_gradient": 0.0002, "clone_scale": 0.01, "prune_opacity": 0.005, "prune_contribution": 0.01, "birth_rounds": 2, "static_opacity_penalty": 0.05, "dynamic_opacity_penalty": 0.005, "infill": 0.03}, "labels": {"initial": "auto", "adaptive": true, "still_pixels": 0.25, "restless_error": 0.05}, "learning_rates": {"position": 0.001, "position_final": 5e-05, "motion": 0.4, "rotation": 0.003, "turning": 0.001, "log_scale": 0.01, "opacity": 0.05, "rgb": 0.005, "time_center": 0.001, "time_log_precision": 0.03, "colour_correction": 0.001, "lens_falloff": 0.002}}, "encode": {"budget": "default", "by_segment": false}}','succeeded',1,1,'',0,0,'{}','','done-ab442600','','',1.79585719052447414395e+09,1.79585719108954215052e+09,'["old"]',0,0.0,0.0,'','auto','Done','b80e4835fdfa09bceec45f71a6af432ca1a41668165b4b6cf66750581e5c87aa');
INSERT INTO "hgs_job" VALUES('waits-2c2599ca','Waits','{HOME}/captures/room','{"preset": "standard", "seed": 0, "capture": {"hold_out": [], "downscale": 1, "downscale_cameras": [], "frame_memory_mib": 1536, "trust_poses": false, "sync": "auto"}, "points": {"static": 30000, "dynamic": 8000, "interval": 0.3333333333333333, "stereo": true, "continued": true, "discs": false}, "train": {"iterations": 3, "stages": "together", "motion_order": 3, "segment_frames": 150, "antialiased": true, "elongation": 20.0, "colour_correction": true, "lens_falloff": true, "dssim": 0.2, "coarse_until": 0.25, "moving_steps": 3.0, "settle_from": 0.6, "settled": 0.02, "hold_from": 0.85, "held_statics": 3.0, "average_from": 0.9, "steps_by_life": true, "checkpoint_every": 500, "backend": "auto", "density": {"method": "gradient", "max_static": 80000, "max_dynamic": 15000, "start": 0.04, "end": 0.6, "every": 50, "grow_gradient": 0.0002, "clone_scale": 0.01, "prune_opacity": 0.005, "prune_contribution": 0.01, "birth_rounds": 2, "static_opacity_penalty": 0.05, "dynamic_opacity_penalty": 0.005, "infill": 0.03}, "labels": {"initial": "auto", "adaptive": true, "still_pixels": 0.25, "restless_error": 0.05}, "learning_rates": {"position": 0.001, "position_final": 5e-05, "motion": 0.4, "rotation": 0.003, "turning": 0.001, "log_scale": 0.01, "opacity": 0.05, "rgb": 0.005, "time_center": 0.001, "time_log_precision": 0.03, "colour_correction": 0.001, "lens_falloff": 0.002}}, "encode": {"budget": "default", "by_segment": false}}','queued',1,0,'',0,0,'{}','','','','',1.79585719055337548252e+09,1.79585719055337548252e+09,'["old"]',0,0.0,0.0,'','auto','Waits','e2ff565a4467b89b8605e2e61f6741c88d941a53be2d76ecdfe18f08c4ea6e22');
INSERT INTO "hgs_job" VALUES('cancelled-551faa09','Cancelled','{HOME}/captures/room','{"preset": "standard", "seed": 0, "capture": {"hold_out": [], "downscale": 1, "downscale_cameras": [], "frame_memory_mib": 1536, "trust_poses": false, "sync": "auto"}, "points": {"static": 30000, "dynamic": 8000, "interval": 0.3333333333333333, "stereo": true, "continued": true, "discs": false}, "train": {"iterations": 3, "stages": "together", "motion_order": 3, "segment_frames": 150, "antialiased": true, "elongation": 20.0, "colour_correction": true, "lens_falloff": true, "dssim": 0.2, "coarse_until": 0.25, "moving_steps": 3.0, "settle_from": 0.6, "settled": 0.02, "hold_from": 0.85, "held_statics": 3.0, "average_from": 0.9, "steps_by_life": true, "checkpoint_every": 500, "backend": "auto", "density": {"method": "gradient", "max_static": 80000, "max_dynamic": 15000, "start": 0.04, "end": 0.6, "every": 50, "grow_gradient": 0.0002, "clone_scale": 0.01, "prune_opacity": 0.005, "prune_contribution": 0.01, "birth_rounds": 2, "static_opacity_penalty": 0.05, "dynamic_opacity_penalty": 0.005, "infill": 0.03}, "labels": {"initial": "auto", "adaptive": true, "still_pixels": 0.25, "restless_error": 0.05}, "learning_rates": {"position": 0.001, "position_final": 5e-05, "motion": 0.4, "rotation": 0.003, "turning": 0.001, "log_scale": 0.01, "opacity": 0.05, "rgb": 0.005, "time_center": 0.001, "time_log_precision": 0.03, "colour_correction": 0.001, "lens_falloff": 0.002}}, "encode": {"budget": "default", "by_segment": false}}','cancelled',1,0,'',0,0,'{}','','','','',1.79585719055889892576e+09,1.79585719073734927176e+09,'["old"]',0,0.0,0.0,'','auto','Cancelled','ee578c75e6a3a6bd7baa752b53f33d743ec3565ac486c7b7f96aef12001eb9ac');
CREATE TABLE hgs_job_label (
	label VARCHAR(64) NOT NULL, 
	job_id VARCHAR(64) NOT NULL, 
	PRIMARY KEY (label, job_id)
);
INSERT INTO "hgs_job_label" VALUES('old','done-ab442600');
INSERT INTO "hgs_job_label" VALUES('old','waits-2c2599ca');
INSERT INTO "hgs_job_label" VALUES('old','cancelled-551faa09');
CREATE TABLE hgs_key (
	id VARCHAR(12) NOT NULL, 
	name VARCHAR(64) NOT NULL, 
	scopes TEXT NOT NULL, 
	hash VARCHAR(64) NOT NULL, 
	created FLOAT NOT NULL, 
	expires FLOAT, 
	PRIMARY KEY (id), 
	UNIQUE (name)
);
INSERT INTO "hgs_key" VALUES('2d3890b237f9','anna','view','154bbdcc666ce76b32d55be891b3efcf4b5f5659671e98b02bbc853021dd4af8',1.795857191219247818e+09,NULL);
CREATE TABLE hgs_schema (
	number INTEGER NOT NULL, 
	PRIMARY KEY (number)
);
INSERT INTO "hgs_schema" VALUES(1);
CREATE TABLE hgs_secret (
	name VARCHAR(32) NOT NULL, 
	value VARCHAR(64) NOT NULL, 
	PRIMARY KEY (name)
);
CREATE TABLE hgs_webhook (
	job_id VARCHAR(64) NOT NULL, 
	attempt INTEGER NOT NULL, 
	url TEXT NOT NULL, 
	body TEXT NOT NULL, 
	ended FLOAT NOT NULL, 
	tries INTEGER NOT NULL, 
	next_try FLOAT, 
	delivered FLOAT NOT NULL, 
	error TEXT NOT NULL, 
	PRIMARY KEY (job_id, attempt)
);
CREATE TABLE hgs_worker (
	id VARCHAR(128) NOT NULL, 
	host TEXT NOT NULL, 
	pid INTEGER NOT NULL, 
	device TEXT NOT NULL, 
	job_id VARCHAR(64) NOT NULL, 
	idle_because TEXT NOT NULL, 
	started FLOAT NOT NULL, 
	seen FLOAT NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE notifications (
    message_uuid TEXT NOT NULL DEFAULT (hex(randomblob(16))) PRIMARY KEY,
    destination_uuid TEXT NOT NULL,
    topic TEXT,
    message TEXT NOT NULL,
    created_at_epoch_ms INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000), "serialization" TEXT DEFAULT NULL, "consumed" BOOLEAN NOT NULL DEFAULT FALSE, consumed_by_function_id INTEGER,
    FOREIGN KEY (destination_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE "operation_outputs" (
    workflow_uuid TEXT NOT NULL,
    function_id INTEGER NOT NULL,
    function_name TEXT NOT NULL DEFAULT '',
    output TEXT,
    error TEXT,
    child_workflow_id TEXT,
    started_at_epoch_ms INTEGER,
    completed_at_epoch_ms INTEGER,
    serialization TEXT,
    application_name TEXT DEFAULT NULL,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    PRIMARY KEY (workflow_uuid, function_id)
);
CREATE TABLE queues (
    queue_id TEXT PRIMARY KEY DEFAULT (hex(randomblob(16))),
    name TEXT NOT NULL UNIQUE,
    concurrency INTEGER,
    worker_concurrency INTEGER,
    rate_limit_max INTEGER,
    rate_limit_period_sec REAL,
    priority_enabled BOOLEAN NOT NULL DEFAULT FALSE,
    partition_queue BOOLEAN NOT NULL DEFAULT FALSE,
    polling_interval_sec REAL NOT NULL DEFAULT 1.0,
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    updated_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
, "application_name" TEXT DEFAULT NULL, "partition_concurrency" INTEGER DEFAULT NULL, "partition_worker_concurrency" INTEGER DEFAULT NULL, "partition_rate_limit_max" INTEGER DEFAULT NULL, "partition_rate_limit_period_sec" REAL DEFAULT NULL);
CREATE TABLE streams (
    workflow_uuid TEXT NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL,
    "offset" INTEGER NOT NULL, function_id INTEGER NOT NULL DEFAULT 0, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, key, "offset"),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_events (
    workflow_uuid TEXT NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, key),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_events_history (
    workflow_uuid TEXT NOT NULL,
    function_id INTEGER NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, function_id, key),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid)
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_input (
    workflow_uuid TEXT NOT NULL PRIMARY KEY,
    inputs TEXT,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
);
INSERT INTO "workflow_input" VALUES('done-ab442600:1','{"namedArgs":{},"positionalArgs":["done-ab442600",1,0,"initialise"]}',1795857190000);
INSERT INTO "workflow_input" VALUES('waits-2c2599ca:1','{"namedArgs":{},"positionalArgs":["waits-2c2599ca",1,0,"initialise"]}',1795857190000);
INSERT INTO "workflow_input" VALUES('cancelled-551faa09:1','{"namedArgs":{},"positionalArgs":["cancelled-551faa09",1,0,"initialise"]}',1795857190000);
CREATE TABLE workflow_output (
    workflow_uuid TEXT NOT NULL PRIMARY KEY,
    output TEXT,
    error TEXT,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
);
CREATE TABLE workflow_schedules (
    schedule_id TEXT PRIMARY KEY,
    schedule_name TEXT NOT NULL UNIQUE,
    workflow_name TEXT NOT NULL,
    workflow_class_name TEXT,
    schedule TEXT NOT NULL,
    status TEXT NOT NULL DEFAULT 'ACTIVE',
    context TEXT NOT NULL
, "last_fired_at" TEXT DEFAULT NULL, "automatic_backfill" BOOLEAN NOT NULL DEFAULT FALSE, "cron_timezone" TEXT DEFAULT NULL, "queue_name" TEXT DEFAULT NULL, "application_name" TEXT DEFAULT NULL);
CREATE TABLE workflow_status (
    workflow_uuid TEXT PRIMARY KEY,
    status TEXT,
    name TEXT,
    authenticated_user TEXT,
    assumed_role TEXT,
    authenticated_roles TEXT,
    request TEXT,
    output TEXT,
    error TEXT,
    executor_id TEXT,
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    updated_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    application_version TEXT,
    application_id TEXT,
    class_name TEXT DEFAULT NULL,
    config_name TEXT DEFAULT NULL,
    recovery_attempts INTEGER DEFAULT 0,
    queue_name TEXT,
    workflow_timeout_ms INTEGER,
    workflow_deadline_epoch_ms INTEGER,
    inputs TEXT,
    started_at_epoch_ms INTEGER,
    deduplication_id TEXT,
    priority INTEGER NOT NULL DEFAULT 0
, queue_partition_key TEXT, forked_from TEXT, "owner_xid" TEXT DEFAULT NULL, "parent_workflow_id" TEXT DEFAULT NULL, "serialization" TEXT DEFAULT NULL, "delay_until_epoch_ms" BIGINT DEFAULT NULL, "was_forked_from" BOOLEAN NOT NULL DEFAULT FALSE, "rate_limited" BOOLEAN NOT NULL DEFAULT FALSE, "completed_at" BIGINT, "attributes" TEXT, "schedule_name" TEXT, "debounce_deadline_epoch_ms" BIGINT DEFAULT NULL, "is_debounced" BOOLEAN NOT NULL DEFAULT FALSE, "application_name" TEXT DEFAULT NULL, "creator_xid" TEXT DEFAULT NULL);
INSERT INTO "workflow_status" VALUES('done-ab442600:1','ENQUEUED','train_job',NULL,NULL,NULL,NULL,NULL,NULL,NULL,1795857190000,1795857190000,NULL,NULL,NULL,NULL,0,'training',NULL,NULL,NULL,NULL,NULL,1000,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,NULL,'null',NULL,NULL,0,'hgs','1c5b9452-7795-491e-b6d2-84b62e1a5bec');
INSERT INTO "workflow_status" VALUES('waits-2c2599ca:1','ENQUEUED','train_job',NULL,NULL,NULL,NULL,NULL,NULL,NULL,1795857190000,1795857190000,NULL,NULL,NULL,NULL,0,'training',NULL,NULL,NULL,NULL,NULL,1000,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,NULL,'null',NULL,NULL,0,'hgs','4f7a6431-8e68-4b63-ab7f-72142991db87');
INSERT INTO "workflow_status" VALUES('cancelled-551faa09:1','CANCELLED','train_job',NULL,NULL,NULL,NULL,NULL,NULL,NULL,1795857190000,1795857190000,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,1000,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795857190000,'null',NULL,NULL,0,'hgs','04d2a4da-5f1a-40d0-83c0-f287f55c4ed2');
CREATE INDEX workflow_status_created_at_index ON workflow_status (created_at);
CREATE INDEX idx_workflow_topic ON notifications (destination_uuid, topic);
CREATE INDEX "idx_workflow_status_delayed" ON "workflow_status" ("delay_until_epoch_ms") WHERE status = 'DELAYED';
CREATE INDEX "idx_workflow_status_forked_from" ON "workflow_status" ("forked_from") WHERE "forked_from" IS NOT NULL;
CREATE INDEX "idx_workflow_status_parent_workflow_id" ON "workflow_status" ("parent_workflow_id") WHERE "parent_workflow_id" IS NOT NULL;
CREATE UNIQUE INDEX "uq_workflow_status_dedup_id" ON "workflow_status" ("queue_name", "deduplication_id") WHERE "deduplication_id" IS NOT NULL;
CREATE INDEX "idx_workflow_status_pending" ON "workflow_status" ("created_at") WHERE "status" = 'PENDING';
CREATE INDEX "idx_workflow_status_failed" ON "workflow_status" ("status", "created_at") WHERE "status" IN ('ERROR', 'CANCELLED', 'MAX_RECOVERY_ATTEMPTS_EXCEEDED');
CREATE INDEX "idx_workflow_status_rate_limited" ON "workflow_status" ("queue_name", "started_at_epoch_ms") WHERE "rate_limited" = TRUE;
CREATE INDEX "idx_workflow_status_completed_at" ON "workflow_status" ("completed_at") WHERE "completed_at" IS NOT NULL;
CREATE INDEX "idx_workflow_status_started_at" ON "workflow_status" ("started_at_epoch_ms") WHERE "started_at_epoch_ms" IS NOT NULL;
CREATE INDEX "idx_workflow_status_schedule_name" ON "workflow_status" ("schedule_name") WHERE "schedule_name" IS NOT NULL;
CREATE UNIQUE INDEX "uq_application_versions_owner_version"
    ON application_versions ("application_name", "version_name")
    WHERE "application_name" IS NOT NULL;
CREATE UNIQUE INDEX "uq_application_versions_unclaimed_version"
    ON application_versions ("version_name")
    WHERE "application_name" IS NULL;
CREATE INDEX idx_workflow_input_retention
    ON workflow_input (retention_timestamp);
CREATE INDEX idx_workflow_output_retention
    ON workflow_output (retention_timestamp);
CREATE INDEX idx_operation_outputs_retention
    ON operation_outputs (retention_timestamp);
CREATE INDEX "idx_workflow_status_in_flight_v2" ON "workflow_status" ("queue_name", "status", "priority", "created_at", "application_name") WHERE "status" IN ('ENQUEUED', 'PENDING');
CREATE INDEX "idx_workflow_status_partition_dequeue_v3" ON "workflow_status" ("queue_name", "status", "queue_partition_key", "priority", "created_at", "workflow_uuid", "application_name") WHERE "status" IN ('ENQUEUED', 'PENDING') AND "queue_partition_key" IS NOT NULL;
CREATE INDEX "idx_operation_outputs_completed_at_function_name_v2" ON "operation_outputs" ("completed_at_epoch_ms", "function_name", "application_name");
CREATE INDEX "idx_workflow_status_deadline" ON "workflow_status" ("workflow_deadline_epoch_ms") WHERE "status" IN ('ENQUEUED', 'PENDING', 'DELAYED') AND "workflow_deadline_epoch_ms" IS NOT NULL;
CREATE INDEX "idx_application_versions_timestamp" ON "application_versions" ("version_timestamp" DESC);
CREATE INDEX "idx_application_versions_owner_timestamp" ON "application_versions" ("application_name", "version_timestamp" DESC);
CREATE INDEX ix_hgs_job_state ON hgs_job (state);
CREATE UNIQUE INDEX ix_hgs_job_request_key ON hgs_job (request_key);
CREATE INDEX ix_hgs_job_created ON hgs_job (created);
CREATE INDEX ix_hgs_job_list ON hgs_job (state, created, id, title);
CREATE INDEX ix_hgs_job_capture ON hgs_job (capture);
CREATE INDEX ix_hgs_job_label_job_id ON hgs_job_label (job_id);
CREATE INDEX ix_hgs_webhook_next_try ON hgs_webhook (next_try);
COMMIT;
