"use strict";
// Every word that the page shows, in both languages.
const WORDS = {
  en: {
    speed: "speed", froude: "Froude number", cost: "cost of transport", time: "time",
    standing: "standing", walking: "walking", running: "running", mixed: "mixed", fallen: "fallen",
    stageLabel: "The biped in side view; drag to push its hip", omegaLabel: "Command omega v",
    dragHint: "Drag on the picture to push the hip.",
    toRun: "→ 3 in 0.4 s", toWalk: "→ 0 in 0.4 s", round: "walk – run – walk",
    pause: "pause", goOn: "resume", step: "one step", reset: "start again", pace: "pace",
    compare: "compare with the original body",
    pushBack: "◀ push", pushForward: "push ▶", force: "force", duration: "for",
    save: "save the last", saveTimeLabel: "seconds to save", saveRecording: "recording (CSV)", saveProfile: "command (CSV)",
    savePicture: "stride (PNG)", saveGif: "film (GIF)", saveFilm: "film (MP4)", savePage: "page (HTML)",
    saving: "making the file …", saved: "saved",
    play: "play", stop: "stop", scrubLabel: "time in the recording",
    body: "Body", bodyReset: "reset", first: "first", second: "second", stripsLabel: "Support, energies, speed, cost and reward over time",
    support: "support", right: "right", left: "left", energies: "energy − mean", kinetic: "kinetic", gravitational: "gravitational",
    elastic: "elastic", reward: "reward per control period", costShort: "cost of transport", timeAxis: "time (s)",
    rEnergy: "energy", rVelocity: "velocity", rForward: "forward", rAlive: "alive", rLeg: "leg", rFriction: "friction", rWork: "work",
    command: "command", trained: "trained",
    lost: "The program has ended or cannot be reached; trying again …", again: "fallen – starts again",
    runTitle: "Training run", evaluation: "controller of evaluation", curveLabel: "Learning curve", criteriaLabel: "Criteria met at each evaluation",
    returns: "return of an episode", criteria: "criteria met", steps: "environment steps", finished: "finished", training: "training",
    best: "best so far", unmet: "not met", noEvaluation: "no evaluation yet",
    walks: "walks", runs: "runs",
    keys: "Keys: ← → ω_v, space pause, . one step, R start again, 1 2 3 preset changes, , and ; push back and forward.",
    replayKeys: "Keys: space play or stop, ← → move in time.",
    bodyNames: {
      hip_mass_kg: "hip mass (kg)", thigh_mass_kg: "thigh mass (kg)", tibia_mass_kg: "tibia mass (kg)", foot_mass_kg: "foot mass (kg)",
      hip_stiffness_nm_per_rad: "hip stiffness (N m/rad)", hip_damping_nms_per_rad: "hip damping (N m s/rad)",
      k1_n_per_m: "k₁ foot–thigh (N/m)", k2_n_per_m: "k₂ tibia–foot (N/m)", k3_n_per_m: "k₃ tibia–thigh (N/m)",
      c1_ns_per_m: "c₁ (N s/m)", c2_ns_per_m: "c₂ (N s/m)", actuator_force_n: "actuator force (N)", friction: "friction",
      gravity_m_per_s2: "gravity (m/s²)",
    },
  },
  ja: {
    speed: "速度", froude: "フルード数", cost: "輸送コスト", time: "時間",
    standing: "静止", walking: "歩行", running: "走行", mixed: "混合", fallen: "転倒",
    stageLabel: "二脚モデルの側面図。ドラッグで腰を押す", omegaLabel: "指令 オメガ v",
    dragHint: "図の上をドラッグすると腰を押せます。",
    toRun: "0.4 s で 3 へ", toWalk: "0.4 s で 0 へ", round: "歩行 – 走行 – 歩行",
    pause: "一時停止", goOn: "再開", step: "1 周期進める", reset: "最初から", pace: "再生速度",
    compare: "元の身体を並べる",
    pushBack: "◀ 押す", pushForward: "押す ▶", force: "力", duration: "時間",
    save: "直近を保存", saveTimeLabel: "保存する秒数", saveRecording: "記録 (CSV)", saveProfile: "指令 (CSV)",
    savePicture: "1 ストライド (PNG)", saveGif: "動画 (GIF)", saveFilm: "動画 (MP4)", savePage: "ページ (HTML)",
    saving: "ファイルを作成中 …", saved: "保存しました",
    play: "再生", stop: "停止", scrubLabel: "記録の時刻",
    body: "身体", bodyReset: "元に戻す", first: "一体目", second: "二体目", stripsLabel: "支持相、エネルギー、速度、輸送コスト、報酬の時間変化",
    support: "支持相", right: "右", left: "左", energies: "エネルギー（平均との差）", kinetic: "運動", gravitational: "重力",
    elastic: "弾性", reward: "制御周期あたりの報酬", costShort: "輸送コスト", timeAxis: "時間 (s)",
    rEnergy: "エネルギー", rVelocity: "速度", rForward: "前進", rAlive: "生存", rLeg: "脚", rFriction: "摩擦", rWork: "仕事",
    command: "指令", trained: "学習範囲",
    lost: "プログラムに接続できません。再接続を試みています …", again: "転倒。最初からやり直します",
    runTitle: "学習", evaluation: "評価時のコントローラ", curveLabel: "学習曲線", criteriaLabel: "各評価で満たした基準の数",
    returns: "エピソードの収益", criteria: "満たした基準", steps: "環境ステップ", finished: "終了", training: "学習中",
    best: "これまでの最良", unmet: "未達", noEvaluation: "評価はまだありません",
    walks: "歩行", runs: "走行",
    keys: "キー: ← → で ω_v、スペースで一時停止、. で 1 周期、R で最初から、1 2 3 で指令の変更、, と ; で後ろ・前へ押す。",
    replayKeys: "キー: スペースで再生・停止、← → で時刻を移動。",
    bodyNames: {
      hip_mass_kg: "腰の質量 (kg)", thigh_mass_kg: "大腿の質量 (kg)", tibia_mass_kg: "脛の質量 (kg)", foot_mass_kg: "足の質量 (kg)",
      hip_stiffness_nm_per_rad: "股関節の剛性 (N m/rad)", hip_damping_nms_per_rad: "股関節の減衰 (N m s/rad)",
      k1_n_per_m: "k₁ 足–大腿 (N/m)", k2_n_per_m: "k₂ 脛–足 (N/m)", k3_n_per_m: "k₃ 脛–大腿 (N/m)",
      c1_ns_per_m: "c₁ (N s/m)", c2_ns_per_m: "c₂ (N s/m)", actuator_force_n: "アクチュエータの力 (N)", friction: "摩擦係数",
      gravity_m_per_s2: "重力加速度 (m/s²)",
    },
  },
};

let language = (navigator.language || "en").startsWith("ja") ? "ja" : "en";
const spoken = [];
const word = (key) => WORDS[language][key] ?? key;

// Puts the words into the page; what draws its own text asks again with every frame.
function speak() {
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll("[data-word]")) element.textContent = word(element.dataset.word);
  for (const element of document.querySelectorAll("[data-label]")) element.setAttribute("aria-label", word(element.dataset.label));
  const other = document.getElementById("language");
  other.textContent = language === "en" ? "日本語" : "English";
  other.lang = language === "en" ? "ja" : "en";
  other.setAttribute("aria-label", other.textContent);
  for (const again of spoken) again();
}
document.getElementById("language").addEventListener("click", () => {
  language = language === "en" ? "ja" : "en";
  speak();
});
