#![allow(missing_docs)]
use cordis_anima::{Loaded, Options};
fn main(){
 for f in std::env::args().skip(1) {
  let l = Loaded::open(std::path::Path::new(&f)).unwrap();
  match l.compile(&Options{energy:false,audited:false,exact:false,..Options::default()}) {
   Ok(c)=>{ let s=c.scene;
    let mut names: Vec<String>=Vec::new();
    for (w,list) in [("r",&s.reads),("f",&s.forces),("w",&s.writes),("m",&s.moves)] { for o in list.iter() { 
      let law=o.law.map(|l| format!("{}{}{}{}", l.code, if l.linear {":lin"} else {""}, if l.mem>0 {":mem"} else {""}, match l.stage {ca_core::op::SolveStage::Explicit=>"",ca_core::op::SolveStage::Single(_)=>":SINGLE",ca_core::op::SolveStage::Coupled(_)=>":COUPLED"})).unwrap_or_default();
      let form=&o.form;
      names.push(format!("{w}:{}{} {}{}{}{}{}{}{}",o.name,if law.is_empty(){String::new()}else{format!("[{law}]")}, if form.folded {"folded "} else {""}, if form.integrate!=ca_core::op::Integrate::No {"fused "} else {""}, match form.measure {ca_core::op::MeasureKind::Line=>"",ca_core::op::MeasureKind::Along=>"along ",ca_core::op::MeasureKind::Radial=>"radial "}, if form.onto.is_some(){"ONTO "}else{""}, if form.set {"SET "} else {""}, if form.tap {"tap "} else {""}, if form.hub!=ca_core::op::Hub::None {"fan"} else {""})); } }
    names.sort(); names.dedup();
    println!("== {} slow={} substeps={} driven={} implicit={} waves={}\n   {}", f, s.layout.slow.is_some(), s.layout.oversample(), s.live.driven.len(), s.layout.implicit.is_some(), s.layout.waves.delays.len(), names.join("; "));
   }
   Err(_)=>println!("== {f} ERR"),
  }
 }
}
