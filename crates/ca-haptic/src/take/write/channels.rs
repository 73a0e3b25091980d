//! Channels of a take: its topics and the schema of each.
//!
//! All are declared before the first frame, so that a viewer knows them from the first chunk.

use super::super::header::Header;
use super::super::next_version::MODEL;
use super::super::records::{Energy, Hand, Hashed, Lost, Ordered, Reloaded, Rt};
use super::super::{cdr, topic};
use super::views;
use crate::frame::{DOF, DeviceFrame, ForceFrame};
use ca_core::Scene;
use mcap::write::NoSeek;
use mcap::{McapResult, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

pub(super) struct DeviceChannels {
    pub(super) name: String,
    pub(super) joints: Vec<String>,
    /// Position \[m\] of the hand and force \[N\] on it.
    pub(super) at: ([f64; DOF], [f32; DOF]),
    pub(super) said: (u32, u16),
    pub(super) take: u16,
    pub(super) give: u16,
}

pub(super) struct Ids {
    pub(super) change: u16,
    pub(super) param: u16,
    pub(super) reload: u16,
    pub(super) model: u16,
    pub(super) order: u16,
    pub(super) hand: u16,
    pub(super) profile: u16,
    pub(super) hash: u16,
    pub(super) energy: u16,
    pub(super) lost: u16,
    pub(super) rt: u16,
    pub(super) sound: u16,
    pub(super) audio: u16,
    pub(super) joints: u16,
    pub(super) masses: u16,
    pub(super) scene: u16,
    pub(super) log: u16,
}

pub(super) fn declare(
    out: &mut Writer<NoSeek<BufWriter<File>>>,
    header: &Header,
    scene: &Scene,
) -> McapResult<(Ids, Vec<DeviceChannels>)> {
    let none = BTreeMap::new();
    let mut flat = |topic: &str, name: &str, schema: &str| {
        let id = out.add_schema(&format!("ca_v1/msg/{name}"), "ros2msg", schema.as_bytes())?;
        out.add_channel(id, topic, "cdr", &none)
    };
    let mut hands = Vec::new();
    for s in &header.setups {
        let name = &s.device;
        hands.push(DeviceChannels {
            take: flat(&topic::device(name), "DeviceFrame", DeviceFrame::SCHEMA)?,
            give: flat(&topic::force(name), "ForceFrame", ForceFrame::SCHEMA)?,
            joints: (0..s.profile.dof as usize).map(|k| views::joint(scene, name, k)).collect(),
            name: name.clone(),
            at: ([0.0; DOF], [0.0; DOF]),
            said: (u32::MAX, u16::MAX),
        });
    }
    let [change, param, reload, model, order, hand, profile, hash, energy, lost, rt, sound] = [
        (topic::CHANGE, "Change", cdr::CHANGE),
        (topic::PARAM, "Param", cdr::PARAM),
        (topic::RELOAD, "Reloaded", Reloaded::SCHEMA),
        (topic::MODEL, "Model", MODEL),
        (topic::ORDER, "Ordered", Ordered::SCHEMA),
        (topic::HAND, "Hand", Hand::SCHEMA),
        (topic::PROFILE, "Profile", cdr::PROFILE),
        (topic::HASH, "Hashed", Hashed::SCHEMA),
        (topic::ENERGY, "Energy", Energy::SCHEMA),
        (topic::LOST, "Lost", Lost::SCHEMA),
        (topic::RT, "Rt", Rt::SCHEMA),
        (topic::SOUND, "Sound", cdr::SOUND),
    ]
    .map(|(topic, name, schema)| flat(topic, name, schema));
    let mut view = |topic: &str, (name, encoding, data): (String, String, Vec<u8>)| {
        let id = out.add_schema(&name, &encoding, &data)?;
        out.add_channel(id, topic, "protobuf", &none)
    };
    let ids = Ids {
        change: change?,
        param: param?,
        reload: reload?,
        model: model?,
        order: order?,
        hand: hand?,
        profile: profile?,
        hash: hash?,
        energy: energy?,
        lost: lost?,
        rt: rt?,
        sound: sound?,
        audio: view(topic::AUDIO, views::schema::<foxglove::messages::RawAudio>())?,
        joints: view(topic::JOINTS, views::schema::<foxglove::messages::JointStates>())?,
        masses: view(topic::MASSES, views::schema::<foxglove::messages::PointCloud>())?,
        scene: view(topic::SCENE, views::schema::<foxglove::messages::SceneUpdate>())?,
        log: view(topic::LOG, views::schema::<foxglove::messages::Log>())?,
    };
    Ok((ids, hands))
}
