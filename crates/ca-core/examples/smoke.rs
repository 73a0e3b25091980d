use ca_core::*;
fn main() {
    let cat = Catalog::core();
    for k in cat.iter() {
        let (m, d) = model::read::read(k.example, k.code, &cat);
        if !d.list.is_empty() { println!("{}", model::render::text(&d, &m, false)); }
        match compile(&m, &cat, &Options{energy:true,..Options::default()}) {
            Ok(s) => {
                if !s.diags.list.is_empty() { println!("{}", model::render::text(&s.diags, &m, false)); }
                let mut st = s.state();
                let mut peak=0f64; let mut en=0.0;
                for n in 0..48000 {
                    let t = n as f64/48000.0;
                    for (name, pts) in &s.gestures {
                        if let Some(i)=s.input(name) {
                            let mut v=pts[0][1];
                            for w in pts.windows(2){ if t>=w[0][0] && t<=w[1][0] { v = w[0][1]+(w[1][1]-w[0][1])*(t-w[0][0])/(w[1][0]-w[0][0]).max(1e-12);} else if t>w[1][0]{v=w[1][1];} }
                            st.input[i]=v;
                        }
                    }
                    tick(&s,&mut st); peak=peak.max(st.output[0].abs()); if n>40000 {en+=st.output[0].powi(2);}
                }
                let l=st.ledger.as_ref().unwrap().balance();
                println!("{:12} {:?} ops {:?} peak {:.3e} late {:.2e} level {} bound {:.3} resid/peak {:.2e} worst {:.2e} source {:.2e} lost {:.2e} work {:.2e}", k.code, s, s.forces.iter().map(|o|o.name).collect::<Vec<_>>(), peak, (en/8000.0).sqrt(), s.certificate.level, s.certificate.bound, l.residual/l.peak, st.ledger.as_ref().unwrap().worst/l.peak, l.source,l.lost,l.work);
            }
            Err(d) => println!("{} FAILED\n{}", k.code, model::render::text(&d, &m, false)),
        }
    }
}
