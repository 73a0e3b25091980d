// The messages between this page and the program, version 1, as types in JSDoc. Made by
// `UPDATE=1 cargo test -p ca-session --test protocol` from crates/ca-session/src/protocol: do not edit. The page does not
// load this file.

export {};

/**
 * A live parameter.
 * @typedef {object} Param
 * @property {string} name its name
 * @property {number} value its value at load (SI)
 * @property {number|null} min its minimum (SI); `null` without a bound
 * @property {number|null} max its maximum (SI); `null` without a bound
 * @property {string} unit its unit; empty for a plain number
 * @property {string} doc its description
 */

/**
 * A preset of the model.
 * @typedef {object} Preset
 * @property {string} name its name
 * @property {Object<string, number>} values values of live parameters, by name (SI)
 */

/**
 * A port.
 * @typedef {object} PortInfo
 * @property {string} name its name
 * @property {"position"|"force"|"device"} role quantity that it receives
 * @property {number|null} mass number of the mass that it moves, in the drawing
 * @property {number} rest its rest position [m]
 */

/**
 * A device.
 * @typedef {object} DeviceState
 * @property {string} name its name
 * @property {string} mode mode of its forces
 * @property {string} cause cause of that mode
 */

/**
 * A MIDI controller that is bound to a live parameter.
 * @typedef {object} Bound
 * @property {number} channel MIDI channel, from 1
 * @property {number} number number of the controller
 * @property {string} name name of the parameter
 */

/**
 * The sound outputs from which a page can choose.
 * @typedef {object} Choices
 * @property {Array<string>} choices names of the outputs; empty if there is no choice
 * @property {string} wanted name of the requested output
 * @property {boolean} busy whether the requested output is being opened
 */

/**
 * The mass that `pick` found.
 * @typedef {object} Picked
 * @property {number} mass its number in the drawing
 * @property {string} name its name in the model
 * @property {string} kind code of its kind
 */

/**
 * Starts or stops the sound for this page. The server of the page handles it.
 * @typedef {object} SoundRequest
 * @property {"sound"} type
 * @property {boolean} on `true` to receive sound
 */

/**
 * Holds a mass where it is, with a finger. All pages together have ten fingers, and each mass has at most one.
 * @typedef {object} GrabRequest
 * @property {"grab"} type
 * @property {number} mass number of the mass in the drawing
 * @property {number} finger number of the finger on this page; 0 if it is left out
 */

/**
 * Pulls the mass that a finger of this page holds.
 * @typedef {object} DragRequest
 * @property {"drag"} type
 * @property {number} finger number of the finger on this page; 0 if it is left out
 * @property {Array<number>} by displacement from rest [m]: `[u]`, or `[x, y, z]` in space
 */

/**
 * Releases the mass that a finger of this page holds.
 * @typedef {object} ReleaseRequest
 * @property {"release"} type
 * @property {number} finger number of the finger on this page; all fingers if it is left out
 */

/**
 * Starts the gesture of the model from its beginning, or stops it.
 * @typedef {object} GestureRequest
 * @property {"gesture"} type
 * @property {boolean} play `true` to start
 */

/**
 * Moves a port to a position or a force, in 17 ms.
 * @typedef {object} PortRequest
 * @property {"port"} type
 * @property {string} name name of the port
 * @property {number} value the position [m] or force [N]
 */

/**
 * Sets live parameters, all in one tick.
 * @typedef {object} SetRequest
 * @property {"set"} type
 * @property {Object<string, number|string>} values by name: a number in SI units, or a text with a unit
 */

/**
 * Changes a value of the model that is not live, as `--set` does. The model is compiled again and keeps playing.
 * @typedef {object} ChangeRequest
 * @property {"change"} type
 * @property {string} name name of the value, such as `string.t60`
 * @property {string} value the new value as text, with a unit if it needs one
 */

/**
 * Restarts from the state at load, with the present values.
 * @typedef {object} RestartRequest
 * @property {"restart"} type
 */

/**
 * As `restart`, then plays the gesture of the model, if there is one.
 * @typedef {object} PlayRequest
 * @property {"play"} type
 */

/**
 * Plays MIDI events.
 * @typedef {object} MidiRequest
 * @property {"midi"} type
 * @property {Array<number>} bytes whole events, at most 96 bytes
 */

/**
 * Binds the MIDI controller that moves next to a live parameter.
 * @typedef {object} LearnRequest
 * @property {"learn"} type
 * @property {string|null} name name of the parameter; `null` to bind none
 */

/**
 * Chooses the sound output.
 * @typedef {object} AudioRequest
 * @property {"audio"} type
 * @property {string} device one of the `choices` of `state`
 */

/**
 * Starts or stops recording sound to a WAV file.
 * @typedef {object} RecordRequest
 * @property {"record"} type
 * @property {boolean} on `true` to start
 */

/**
 * Saves everything done since the start as a take.
 * @typedef {object} SaveRequest
 * @property {"save"} type
 */

/**
 * Stores the model as it is now, with all its changed values. The server then has its text at `model.ca.toml`. A model that takes parts or points from other files is refused.
 * @typedef {object} SnapshotRequest
 * @property {"snapshot"} type
 */

/**
 * Returns the name and kind of a mass.
 * @typedef {object} PickRequest
 * @property {"pick"} type
 * @property {number} mass number of the mass in the drawing
 */

/**
 * Arms the forces of all devices, if the command line allows it, or turns them off.
 * @typedef {object} ArmRequest
 * @property {"arm"} type
 * @property {boolean} on `true` to arm
 */

/**
 * Ends the program.
 * @typedef {object} StopRequest
 * @property {"stop"} type
 */

/** @typedef {SoundRequest|GrabRequest|DragRequest|ReleaseRequest|GestureRequest|PortRequest|SetRequest|ChangeRequest|RestartRequest|PlayRequest|MidiRequest|LearnRequest|AudioRequest|RecordRequest|SaveRequest|SnapshotRequest|PickRequest|ArmRequest|StopRequest} Request */

/**
 * The scene that plays. The first message, and sent again with each new version of the model.
 * @typedef {object} SceneMessage
 * @property {"scene"} type
 * @property {number} generation version of the model that plays, from 1
 * @property {string} title title of the model
 * @property {string} model name of the model
 * @property {number} rate ticks a second [Hz]
 * @property {number} frame ticks of a gesture frame
 * @property {Array<string>} channels names of the outputs
 * @property {any} drawing drawing of the scene, as `ca-view` writes it
 * @property {Array<Param>} params live parameters
 * @property {Array<PortInfo>} ports ports of position and force, and keys of devices
 * @property {boolean} gesture whether the model has a gesture
 * @property {Array<Preset>} presets presets of the model; `set` with the name `preset` and the name of a preset chooses it
 * @property {Array<number>|null} notes MIDI keys that play, lowest first; `null` without any
 * @property {number|null} seconds duration given in the model [s]
 * @property {Array<string>} energy names of the parts whose kinetic energy the message `energy` has
 * @property {string} stability proven stability, in words
 */

/**
 * The present state, four times per second.
 * @typedef {object} StateMessage
 * @property {"state"} type
 * @property {number} tick sound sample computed last
 * @property {number} seconds time of that sample [s]
 * @property {number|null} load computing time as a share of real time; `null` in the first second
 * @property {number} late missed periods
 * @property {number} lost records, samples, pictures, forces and times lost
 * @property {number} clipped samples at the peak limit
 * @property {boolean} diverged whether the model diverged: its values are out of range
 * @property {boolean} playing whether the gesture of the model plays
 * @property {number} pointer the first of `held`; −1 without one
 * @property {Array<number>} held numbers of the masses that fingers hold, in the drawing
 * @property {Array<DeviceState>} devices devices
 * @property {Object<string, number>} params values of the live parameters, by name (SI)
 * @property {number} clients number of open pages
 * @property {string|null} learning the parameter that the next MIDI controller is bound to
 * @property {Array<Bound>} bound MIDI controllers that are bound to parameters
 * @property {string} sound sound output: `page`, or the name of a sound server or device
 * @property {Choices} outputs the outputs of the sound
 * @property {number|null} latency latency from the model to the ear, if a sound output other than the page plays [ms]
 * @property {number|null} underruns number of times the sound device ran out of samples; `null` in the first second
 * @property {boolean} arms whether a page may arm forces
 * @property {boolean} keeps whether a take can be saved
 * @property {string|null} recording the file to which sound is recorded
 */

/**
 * Kinetic energy, about twenty times per second.
 * @typedef {object} EnergyMessage
 * @property {"energy"} type
 * @property {number} seconds time of the model [s]
 * @property {Array<number>} motion energy of each part [J], in the order of `energy` of `scene`
 */

/**
 * A message for the user.
 * @typedef {object} SaidMessage
 * @property {"said"} type
 * @property {boolean} bad whether something went wrong
 * @property {string} text the message
 */

/**
 * A new version of the model was compiled, or has errors.
 * @typedef {object} ReportMessage
 * @property {"report"} type
 * @property {boolean} ok whether it plays
 * @property {string} text its warnings, or why it does not play
 */

/**
 * The answer to a request with an `id`, and to each request that is refused.
 * @typedef {object} ReplyMessage
 * @property {"reply"} type
 * @property {any} id `id` of the request; `null` without one
 * @property {boolean} ok whether it was done
 * @property {string} text what was done, or why not
 * @property {number} [mass] of `pick`: its number in the drawing
 * @property {string} [name] of `pick`: its name in the model
 * @property {string} [kind] of `pick`: code of its kind
 */

/** @typedef {SceneMessage|StateMessage|EnergyMessage|SaidMessage|ReportMessage|ReplyMessage} Message */
