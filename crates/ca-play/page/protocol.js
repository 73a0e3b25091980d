// The messages between this page and the program, version 1, as types in JSDoc. Made by
// `UPDATE=1 cargo test -p ca-session --test protocol` from crates/ca-session/src/protocol: do not edit. The page does not
// load this file.

export {};

/**
 * A live parameter.
 * @typedef {object} Param
 * @property {string} name its name
 * @property {number} value its value at load (SI)
 * @property {number|null} min its least value (SI); `null` without a bound
 * @property {number|null} max its largest value (SI); `null` without a bound
 * @property {string} unit its unit; empty for a plain number
 * @property {string} doc what it is
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
 * @property {"position"|"force"|"device"} role what it takes
 * @property {number|null} mass number of the mass that it moves, in the drawing
 * @property {number} rest where it rests [m]
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
 * The outputs of the sound among which a page chooses.
 * @typedef {object} Choices
 * @property {Array<string>} choices names that can be asked for; empty where nothing can be chosen
 * @property {string} wanted the name that is to play
 * @property {boolean} busy whether what was asked for last is being opened
 */

/**
 * The mass that `pick` found.
 * @typedef {object} Picked
 * @property {number} mass its number in the drawing
 * @property {string} name its name in the model
 * @property {string} kind code of its kind
 */

/**
 * Sound is sent to this page, or no longer. The server of the page answers it.
 * @typedef {object} SoundRequest
 * @property {"sound"} type
 * @property {boolean} on `true` to be sent sound
 */

/**
 * Holds a mass where it is. One page at a time holds a mass.
 * @typedef {object} GrabRequest
 * @property {"grab"} type
 * @property {number} mass number of the mass in the drawing
 */

/**
 * Pulls the mass that this page holds.
 * @typedef {object} DragRequest
 * @property {"drag"} type
 * @property {Array<number>} by the place, from where the mass rests [m]: `[u]`, or `[x, y, z]` in space
 */

/**
 * Lets go of the mass that this page holds.
 * @typedef {object} ReleaseRequest
 * @property {"release"} type
 */

/**
 * Begins the model's own gesture from its start, or ends it.
 * @typedef {object} GestureRequest
 * @property {"gesture"} type
 * @property {boolean} play `true` to begin
 */

/**
 * Sends a port to a position or a force, in 17 ms.
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
 * Changes a number of the model that is not live, as by `--set`. The model is compiled again and plays on.
 * @typedef {object} ChangeRequest
 * @property {"change"} type
 * @property {string} name name of the number, such as `string.t60`
 * @property {string} value its value as text, with a unit where it needs one
 */

/**
 * Begins again as at load, with the numbers as they are.
 * @typedef {object} RestartRequest
 * @property {"restart"} type
 */

/**
 * As `restart`; then the model's own gesture plays, if there is one.
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
 * Chooses what plays the sound.
 * @typedef {object} AudioRequest
 * @property {"audio"} type
 * @property {string} device one of the `choices` of `state`
 */

/**
 * Records sound into a WAV file from now on, or ends that.
 * @typedef {object} RecordRequest
 * @property {"record"} type
 * @property {boolean} on `true` to begin
 */

/**
 * Saves everything that was done since the start as a take.
 * @typedef {object} SaveRequest
 * @property {"save"} type
 */

/**
 * Says which mass this is.
 * @typedef {object} PickRequest
 * @property {"pick"} type
 * @property {number} mass number of the mass in the drawing
 */

/**
 * Forces of all devices on, where the command line allows it, or off.
 * @typedef {object} ArmRequest
 * @property {"arm"} type
 * @property {boolean} on `true` for on
 */

/**
 * Ends the program.
 * @typedef {object} StopRequest
 * @property {"stop"} type
 */

/** @typedef {SoundRequest|GrabRequest|DragRequest|ReleaseRequest|GestureRequest|PortRequest|SetRequest|ChangeRequest|RestartRequest|PlayRequest|MidiRequest|LearnRequest|AudioRequest|RecordRequest|SaveRequest|PickRequest|ArmRequest|StopRequest} Request */

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
 * @property {any} drawing what is drawn, as `ca-view` writes it
 * @property {Array<Param>} params live parameters
 * @property {Array<PortInfo>} ports ports of position and force, and keys of devices
 * @property {boolean} gesture whether the model brings a gesture
 * @property {Array<Preset>} presets presets of the model; `set` with the name `preset` and the name of one of them chooses it
 * @property {Array<number>|null} notes MIDI keys that play, lowest first; `null` without any
 * @property {number|null} seconds how long its author plays it [s]
 * @property {Array<string>} energy names of the parts whose energy of motion `energy` has
 * @property {string} stability what is proven of its stability, in words
 */

/**
 * The present state, four times a second.
 * @typedef {object} StateMessage
 * @property {"state"} type
 * @property {number} tick sound sample that was computed last
 * @property {number} seconds the same [s]
 * @property {number|null} load computing time as a share of real time; `null` in the first second
 * @property {number} late periods that were left out
 * @property {number} lost records, samples, pictures, forces and times that were lost
 * @property {number} clipped samples at the peak limit
 * @property {boolean} diverged whether the numbers of the model left every range
 * @property {boolean} playing whether the model's own gesture plays
 * @property {number} pointer number of the mass that a pointer holds, in the drawing; −1 without one
 * @property {Array<DeviceState>} devices devices
 * @property {Object<string, number>} params values of the live parameters, by name (SI)
 * @property {number} clients pages that are open
 * @property {string|null} learning the parameter that the next MIDI controller is bound to
 * @property {Array<Bound>} bound MIDI controllers that are bound to parameters
 * @property {string} sound what plays the sound: `page`, or the name of a sound server or device
 * @property {Choices} outputs the outputs of the sound
 * @property {number|null} latency time from the model to the ear, where something other than the page plays [ms]
 * @property {number|null} underruns times the sound device had nothing to play; `null` in the first second
 * @property {boolean} arms whether a page may arm forces
 * @property {boolean} keeps whether a take can be saved
 * @property {string|null} recording the file into which sound is recorded
 */

/**
 * Energy of motion, some twenty times a second.
 * @typedef {object} EnergyMessage
 * @property {"energy"} type
 * @property {number} seconds time of the model [s]
 * @property {Array<number>} motion energy of each part [J], in the order of `energy` of `scene`
 */

/**
 * News.
 * @typedef {object} SaidMessage
 * @property {"said"} type
 * @property {boolean} bad whether something went wrong
 * @property {string} text the news
 */

/**
 * An edited model was compiled, or refused.
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
