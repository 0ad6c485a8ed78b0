  // The moving groups of a picture in the plane.
  const poses = data.poses.map(own => typeof own === "number" ? data.poses[own] : own);
  const groups = [...document.querySelectorAll("g.moving")];
  let bodies = 0;
  const trails = data.bodies.map(body => body
    ? svg("polyline", { class: "trail", stroke: data.colours[bodies++ % data.colours.length] }, at("trails")) : null);
  const draw = place => groups.forEach((group, k) => {
    const [x, y, phi, along, across] = poses[k].map(list => between(list, place));
    const scale = along === undefined ? "" : `scale(${along} ${across})`;
    group.setAttribute("transform", `translate(${x} ${y})rotate(${phi * 180 / Math.PI})${scale}`);
    if (trails[k]) {
      const [xs, ys] = poses[k];
      let points = "";
      if (at("trailing").checked) for (let i = 0; i <= place[0]; i++) points += `${xs[i]},${ys[i]} `;
      trails[k].setAttribute("points", points && points + `${x},${y}`);
    }
  });
